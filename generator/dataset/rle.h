// COCO's compressed run lengths, read back.
//
//   run_lengths  as numbers
//   mask_extent  what they add up to
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace ensonify {

// None where the text is not such a code, or its runs do not add to `pixels`.
std::optional<std::vector<std::int64_t>> run_lengths(std::string_view counts, std::int64_t pixels);

struct MaskExtent {
  std::array<std::int64_t, 4> box{};  // x, y, width, height; all 0 of an empty mask
  std::int64_t area = 0;
};

// What the pixels of a mask of rows x columns add up to; none where the text is no code of such a
// mask.
std::optional<MaskExtent> mask_extent(std::string_view counts, std::int64_t rows,
                                      std::int64_t columns);

}  // namespace ensonify
