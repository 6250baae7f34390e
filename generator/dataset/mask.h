// The mask of one instance in one image, as pixels, outlines and COCO's compressed text.
//
//   mask_of     the pixels, cut to their box
//   rings_of    the closed polygons around these pixels and their holes
//   outline_of  one closed polygon that holds exactly these pixels
//   run_lengths  mask_extent   from COCO's compressed text
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace ensonify {

struct Mask {
  int left = 0, top = 0, width = 0, height = 0;  // the box, in pixels of the image
  std::int64_t area = 0;
  std::vector<std::uint8_t> pixels;  // 0 or 1, row-major [height x width]
};

// From runs down the columns of an image of `picture_height` rows. An empty mask has no box.
Mask mask_of(std::span<const std::int64_t> runs, std::int64_t picture_height);

struct Corner {
  int x = 0, y = 0;  // of pixels, in the image: (0, 0) is its upper left corner
  friend bool operator==(const Corner&, const Corner&) = default;
};

// Rings along the edges of pixels. Parts are clockwise (rows downward) and holes counter-clockwise.
// By the even-odd rule, the rings together reproduce the mask exactly. Pixels that touch only at a
// corner have separate rings.
std::vector<std::vector<Corner>> rings_of(const Mask& mask);

// All rings in one polygon. Bridges of zero width, traversed in both directions, join parts and
// holes, so that the even-odd rule reproduces the mask exactly.
std::vector<Corner> outline_of(const Mask& mask);

// None if the text is not such a code, or its runs do not sum to `pixels`.
std::optional<std::vector<std::int64_t>> run_lengths(std::string_view counts, std::int64_t pixels);

struct MaskExtent {
  std::array<std::int64_t, 4> box{};  // x, y, width, height; all 0 of an empty mask
  std::int64_t area = 0;
};

// Sums over the pixels of a mask of rows x columns; none if the text is not the code of such a
// mask.
std::optional<MaskExtent> mask_extent(std::string_view counts, std::int64_t rows,
                                      std::int64_t columns);

}  // namespace ensonify
