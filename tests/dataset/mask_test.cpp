// Outlines give the mask back, whatever its form; run lengths are those of labels/.
#include "dataset/mask.h"

#include <random>
#include <string>

#include "catch.h"
#include "labels/annotations.h"

namespace ensonify {
namespace {

// Rows of a picture, '#' for the mask.
using Picture = std::vector<std::string>;

std::vector<std::int64_t> runs_of(const Picture& picture) {
  std::vector<std::int64_t> runs = {0};
  bool ones = false;
  for (std::size_t x = 0; x < picture[0].size(); ++x) {
    for (const std::string& row : picture) {
      if ((row[x] == '#') != ones) {
        runs.push_back(0);
        ones = !ones;
      }
      ++runs.back();
    }
  }
  return runs;
}

Mask mask_from(const Picture& picture) {
  return mask_of(runs_of(picture), static_cast<std::int64_t>(picture.size()));
}

// The pixels whose centre lies in the closed polygon by the even-odd rule.
Picture filled(const std::vector<Corner>& polygon, const Picture& like) {
  Picture picture(like.size(), std::string(like[0].size(), '.'));
  for (std::size_t y = 0; y < picture.size(); ++y) {
    for (std::size_t x = 0; x < picture[0].size(); ++x) {
      const double px = static_cast<double>(x) + 0.5, py = static_cast<double>(y) + 0.5;
      bool inside = false;
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Corner a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        if ((a.y > py) == (b.y > py)) continue;
        // Summed the same way for an edge and its way back.
        const Corner low = a.y < b.y ? a : b, high = a.y < b.y ? b : a;
        if (px < low.x + (py - low.y) / (high.y - low.y) * (high.x - low.x)) inside = !inside;
      }
      if (inside) picture[y][x] = '#';
    }
  }
  return picture;
}

void check_outline(const Picture& picture) {
  const auto outline = outline_of(mask_from(picture));
  CHECK(filled(outline, picture) == picture);
}

TEST_CASE("an outline holds the pixels of its mask and no others") {
  check_outline({"....", ".#..", "...."});
  check_outline({"####", "####"});
  check_outline({"#.#", ".#.", "#.#"});                          // touching at corners
  check_outline({"#####", "#...#", "#.#.#", "#...#", "#####"});  // a hole with an island
  check_outline({"##..##", "##..##", "......", "..##.."});       // parts
  check_outline({"###", "#.#", "###"});
}

// Protects polygons from crossing themselves: COCO's own tools take each ring as a simple one.
TEST_CASE("pixels that touch at a corner have rings of their own") {
  const auto rings = rings_of(mask_from({"#.", ".#"}));
  REQUIRE(rings.size() == 2);
  CHECK(rings[0] == std::vector<Corner>{{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  CHECK(rings[1] == std::vector<Corner>{{1, 1}, {2, 1}, {2, 2}, {1, 2}});
}

// Protects those who sum areas by the shoelace rule: parts count, holes are taken away.
TEST_CASE("rings enclose the area of the mask, holes counted off") {
  for (const Picture& picture :
       {Picture{"#.#", ".#.", "#.#"}, Picture{"#####", "#...#", "#.#.#", "#...#", "#####"},
        Picture{"......", ".####.", ".#..#.", ".####."}}) {
    const Mask mask = mask_from(picture);
    std::int64_t twice = 0;
    for (const auto& ring : rings_of(mask)) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Corner a = ring[i], b = ring[(i + 1) % ring.size()];
        twice += std::int64_t{a.x} * b.y - std::int64_t{b.x} * a.y;
      }
    }
    CHECK(twice == 2 * mask.area);
  }
}

TEST_CASE("the outline of a rectangle has its four corners") {
  const auto outline = outline_of(mask_from({".....", ".###.", ".###."}));
  CHECK(outline == std::vector<Corner>{{1, 1}, {4, 1}, {4, 3}, {1, 3}});
}

TEST_CASE("outlines of random masks, thick and thin, hold them") {
  std::mt19937 random(7);
  for (const double density : {0.1, 0.5, 0.9}) {
    for (int i = 0; i < 30; ++i) {
      Picture picture(1 + random() % 12, std::string(1 + random() % 12, '.'));
      for (std::string& row : picture) {
        for (char& pixel : row) pixel = random() < density * 4294967296.0 ? '#' : '.';
      }
      picture[0][0] = '#';
      check_outline(picture);
    }
  }
}

TEST_CASE("a mask knows its box and area") {
  const Mask mask = mask_from({"......", "..##..", "...#..", "....#."});
  CHECK(mask.left == 2);
  CHECK(mask.top == 1);
  CHECK(mask.width == 3);
  CHECK(mask.height == 3);
  CHECK(mask.area == 4);
  CHECK(mask.pixels == std::vector<std::uint8_t>{1, 1, 0, 0, 1, 0, 0, 0, 1});
  CHECK(mask_from({"...", "..."}).area == 0);
}

TEST_CASE("run lengths come back from COCO's code") {
  for (const std::vector<std::int64_t>& runs :
       {std::vector<std::int64_t>{12}, {0, 5, 7}, {3, 1, 4, 1, 3}, {100, 2000, 1, 30000, 5, 1}}) {
    std::int64_t pixels = 0;
    for (const std::int64_t run : runs) pixels += run;
    const std::string code = rle_counts(runs);
    CHECK(run_lengths(code, pixels) == runs);
    CHECK_FALSE(run_lengths(code, pixels + 1));
    CHECK_FALSE(run_lengths(code, pixels - 1));
    CHECK_FALSE(run_lengths(code + "\x7f", pixels));
    CHECK_FALSE(run_lengths(code + "o", pixels));  // more follow, but nothing comes
  }
  CHECK_FALSE(run_lengths("oooooooooooooooooooo", 10));
}

}  // namespace
}  // namespace ensonify
