#include "labels/annotations.h"

#include "catch.h"
#include "core/random.h"

using namespace ensonify;

namespace {

// Reads COCO's compressed run lengths back, from the format's description.
std::vector<std::int64_t> decode(const std::string& text) {
  std::vector<std::int64_t> counts;
  for (std::size_t i = 0; i < text.size();) {
    std::int64_t value = 0;
    int shift = 0;
    int group = 0;
    do {
      group = text[i++] - 48;
      value |= std::int64_t{group & 0x1f} << shift;
      shift += 5;
    } while (group & 0x20);
    if (group & 0x10) value -= std::int64_t{1} << shift;
    if (counts.size() > 2) value += counts[counts.size() - 2];
    counts.push_back(value);
  }
  return counts;
}

LabelledImage image_of(int rows, int columns, std::vector<std::uint16_t> instance) {
  LabelledImage image;
  image.rows = rows;
  image.columns = columns;
  image.instance = std::move(instance);
  return image;
}

std::vector<bool> mask_of(const Annotation& annotation, int rows, int columns) {
  std::vector<bool> mask(std::size_t(rows) * columns);
  std::size_t at = 0;
  bool one = false;
  for (const std::int64_t count : decode(annotation.rle_counts)) {
    for (std::int64_t i = 0; i < count; ++i, ++at) {
      mask[(at % rows) * columns + at / rows] = one;
    }
    one = !one;
  }
  CHECK(at == mask.size());
  return mask;
}

}  // namespace

// The published example of COCO's coder: run lengths 6, 1, 40, 4, 5, 4, 5, 4, 21 of a 9 x 10 mask.
TEST_CASE("run lengths are written as COCO's tools do") {
  CHECK(rle_counts({6, 1, 40, 4, 5, 4, 5, 4, 21}) == "61X13mN000`0");
  CHECK(decode(rle_counts({0, 5, 100000, 3, 1, 70000})) ==
        std::vector<std::int64_t>{0, 5, 100000, 3, 1, 70000});
}

// Protects masks, boxes and areas: random pictures come back to the pixel, runs that cross from
// the foot of one column to the head of the next and pictures full of one instance included.
TEST_CASE("masks, boxes and areas agree with the picture") {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const int rows = 1 + static_cast<int>(uniform(seed, 0, 0, 0) * 9);
    const int columns = 1 + static_cast<int>(uniform(seed, 0, 0, 1) * 9);
    std::vector<std::uint16_t> pixels(std::size_t(rows) * columns);
    const int ids = seed == 0 ? 1 : 3;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      pixels[i] = seed == 0 ? 1 : static_cast<std::uint16_t>(uniform(seed, 1, i, 0) * ids);
    }
    const LabelledImage image = image_of(rows, columns, pixels);
    std::vector<std::uint16_t> rebuilt(pixels.size());
    for (const Annotation& a : annotations(instance_runs(image))) {
      const std::vector<bool> mask = mask_of(a, rows, columns);
      std::int64_t area = 0;
      int left = columns, right = -1, top = rows, bottom = -1;
      for (int r = 0; r < rows; ++r) {
        for (int c = 0; c < columns; ++c) {
          if (!mask[std::size_t(r) * columns + c]) continue;
          rebuilt[std::size_t(r) * columns + c] = a.instance;
          ++area;
          left = std::min(left, c), right = std::max(right, c);
          top = std::min(top, r), bottom = std::max(bottom, r);
        }
      }
      CHECK(a.area == area);
      CHECK(a.box == std::array<int, 4>{left, top, right - left + 1, bottom - top + 1});
    }
    CHECK(rebuilt == pixels);
  }
}
