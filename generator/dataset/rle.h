// COCO's compressed run lengths, read back. Private to dataset/.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace ensonify {

struct MaskExtent {
  std::array<std::int64_t, 4> box{};  // x, y, width, height; all 0 of an empty mask
  std::int64_t area = 0;
};

// What the pixels of a mask of rows x columns add up to; none where the text is no code of such a
// mask.
std::optional<MaskExtent> mask_extent(std::string_view counts, std::int64_t rows,
                                      std::int64_t columns);

}  // namespace ensonify
