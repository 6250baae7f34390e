// Where pixels lie in the fan, ticks, colours and masks.
#include "figure/paint.h"

#include <cmath>
#include <set>
#include <tuple>

#include "catch.h"
#include "core/units.h"
#include "figure/compose.h"

using namespace ensonify;

namespace {

// Beams at -30, -10, 10 and 30 degrees, samples at 0, 1, ... 9 m.
PolarFan small_fan() { return {radians(-30), radians(20), 0, 1, 4, 10}; }

// The cell of a place in the Cartesian picture, in metres to port and ahead.
Cell cell_at(const PolarFan& fan, double port, double ahead) {
  const Extent place{port + 0.001, port - 0.001, ahead - 0.001, ahead + 0.001};
  return cartesian_cells(fan, place, 1, 1).at(0);
}

std::uint16_t sum_of(const std::vector<double>& ticks) {
  double sum = 0;
  for (const double tick : ticks) sum += tick;
  return static_cast<std::uint16_t>(std::lround(sum));
}

}  // namespace

TEST_CASE("a Cartesian picture just holds the fan and the sonar") {
  const Extent narrow = cartesian_extent(small_fan());
  CHECK(narrow.left == Approx(9.5 * std::sin(radians(40))));
  CHECK(narrow.right == Approx(-9.5 * std::sin(radians(40))));
  CHECK(narrow.top == Approx(9.5));
  CHECK(narrow.bottom == 0);
  // 240 degrees: wider than its ends, and behind the sonar.
  const Extent wide = cartesian_extent({radians(-110), radians(20), 0, 1, 12, 10});
  CHECK(wide.left == Approx(9.5));
  CHECK(wide.right == Approx(-9.5));
  CHECK(wide.bottom == Approx(9.5 * std::cos(radians(120))));
}

// Protects the sides: beam 0 is to starboard, which is on the right; far is up.
TEST_CASE("pixels find the cell that holds them") {
  const PolarFan fan = small_fan();
  for (const auto& [port_deg, range, column] : {std::tuple(-39.0, 5.2, 0),
                                                {-21.0, 5.2, 0},
                                                {-19.0, 5.2, 1},
                                                {9.0, 8.6, 2},
                                                {31.0, 9.4, 3}}) {
    const Cell cell =
        cell_at(fan, range * std::sin(radians(port_deg)), range * std::cos(radians(port_deg)));
    REQUIRE(cell.inside());
    CHECK(cell.nearest(4) == std::uint64_t(std::lround(range)) * 4 + std::uint64_t(column));
  }
  CHECK_FALSE(cell_at(fan, 5 * std::sin(radians(41)), 5 * std::cos(radians(41))).inside());
  CHECK_FALSE(cell_at(fan, 0, 9.51).inside());
  CHECK_FALSE(cell_at(fan, 0, -1).inside());
  CHECK(cell_at(fan, 0.3, 9.49).inside());

  const Extent extent = cartesian_extent(fan);
  const auto cells = cartesian_cells(fan, extent, 40, 30);
  CHECK(cells.at(5 * 40 + 10).column > 2);  // upper left: port
  CHECK(cells.at(5 * 40 + 30).column < 1);  // upper right: starboard
  CHECK(cells.at(3 * 40 + 20).row > cells.at(20 * 40 + 20).row);
}

TEST_CASE("a polar picture shows cells as they are stored") {
  const auto cells = polar_cells(small_fan(), 8, 19);
  CHECK(cells.at(0).nearest(4) == 0);
  CHECK(cells.at(7).nearest(4) == 3);
  CHECK(cells.at(18 * 8).nearest(4) == 36);
  CHECK(cells.at(18 * 8 + 7).nearest(4) == 39);
  // The first sample is shown from range 0: half as high as the others.
  CHECK(cells.at(1 * 8).nearest(4) == 4);
  const Extent extent = polar_extent(small_fan());
  CHECK(extent.left == Approx(-40));
  CHECK(extent.right == Approx(40));
  CHECK(extent.top == 0);
  CHECK(extent.bottom == Approx(9.5));
}

TEST_CASE("ticks are round numbers between the ends") {
  CHECK(tick_step(10, 5) == Approx(2));
  CHECK(tick_step(11, 5) == Approx(5));
  CHECK(tick_step(0.9, 10) == Approx(0.1));
  CHECK(tick_step(60, 6) == Approx(10));
  CHECK(ticks_in(-0.9, 1.1, 0.5).size() == 4);
  CHECK(ticks_in(4, -4, 2).front() == -4);
  CHECK(ticks_in(0, 30, 0.1).size() == 301);
  CHECK(sum_of(ticks_in(0, 30, 0.1)) == 4515);
  CHECK(tick_text(2, 1) == "2");
  CHECK(tick_text(-2.5, 0.5) ==
        "\xe2\x88\x92"
        "2.5");
  CHECK(tick_text(-0.0, 0.5) == "0.0");
  CHECK(tick_text(0.30000000000000004, 0.1) == "0.3");
  CHECK(tick_text(-0.05, 0.05) ==
        "\xe2\x88\x92"
        "0.05");
}

TEST_CASE("colour maps go from dark to light") {
  for (const ColourMap& map : colour_maps()) {
    INFO(map.name);
    CHECK(find_colour_map(map.name) == &map);
    double before = -1;
    for (int i = 0; i <= 64; ++i) {
      const Rgb8 c = colour_at(map, i / 64.0);
      // Luminance of sRGB.
      const auto linear = [](std::uint8_t v) { return std::pow(v / 255.0, 2.2); };
      const double light =
          0.2126 * linear(c.red) + 0.7152 * linear(c.green) + 0.0722 * linear(c.blue);
      CHECK(light > before - 0.002);
      before = light;
    }
    CHECK(colour_at(map, -1) == colour_at(map, 0));
    CHECK(colour_at(map, 2) == colour_at(map, 1));
  }
  CHECK(find_colour_map("jet") == nullptr);
  CHECK(colour_at(*find_colour_map("viridis"), 0.5) == Rgb8{0x21, 0x91, 0x8c});
  CHECK(colour_at(*find_colour_map("grey"), 1) == Rgb8{255, 255, 255});
}

TEST_CASE("ids near each other have other colours") {
  std::set<std::tuple<int, int, int>> seen;
  for (std::uint32_t id = 0; id < 60; ++id) {
    const Rgb8 c = id_colour(id);
    CHECK(seen.insert({c.red, c.green, c.blue}).second);
  }
  CHECK(id_colour(0) == kNoIdColour);
}

// Protects masks from being mixed, and pictures from colours outside of the fan.
TEST_CASE("masks and levels are painted cell by cell") {
  const PolarFan fan = small_fan();
  const auto cells = polar_cells(fan, 80, 190);
  std::vector<std::uint16_t> ids(40, 0);
  ids[5 * 4 + 2] = 3;
  const RgbImage mask = paint_ids(cells, 80, 190, ids, 4);
  std::size_t pixels = 0;
  for (int y = 0; y < 190; ++y) {
    for (int x = 0; x < 80; ++x) {
      const Rgb8 c = mask.at(x, y);
      REQUIRE((c == id_colour(3) || c == kNoIdColour));
      pixels += c == id_colour(3);
    }
  }
  CHECK(pixels == 20 * 20);
  CHECK(mask.at(50, 100) == id_colour(3));

  std::vector<float> levels(40, 60);
  levels[5 * 4 + 2] = 80;
  const ValueScale scale{find_colour_map("grey"), {60, 80}, Rgb8{1, 2, 3}};
  const RgbImage nearest = paint_values(cells, 80, 190, levels, 4, scale, Sampling::nearest);
  CHECK(nearest.at(50, 100) == Rgb8{255, 255, 255});
  CHECK(nearest.at(50, 111) == Rgb8{0, 0, 0});
  const RgbImage smooth = paint_values(cells, 80, 190, levels, 4, scale, Sampling::bilinear);
  // At row 5.525 and column 2.025 amplitudes of 10 and 1 mix to 5.17: 14.3 dB of 20.
  CHECK(smooth.at(50, 110).red == Approx(182).margin(2));
  levels[0] = std::nanf("");
  CHECK(paint_values(cells, 80, 190, levels, 4, scale, Sampling::nearest).at(3, 3) ==
        Rgb8{1, 2, 3});
  const auto around = cartesian_cells(fan, cartesian_extent(fan), 40, 30);
  CHECK(paint_ids(around, 40, 30, ids, 4).at(0, 29) == Rgb8{255, 255, 255});
}

TEST_CASE("an outline goes around its mask") {
  const auto cells = polar_cells(small_fan(), 80, 190);
  std::vector<std::uint16_t> ids(40, 0);
  ids[5 * 4 + 2] = 3;
  const Rgb8 under{9, 9, 9};
  RgbImage image(80, 190, under);
  outline(image, cells, ids, 4, 2);
  // The mask holds x from 40 to 59, y from 90 to 109.
  CHECK(image.at(39, 100) == id_colour(3));
  CHECK(image.at(38, 100) == id_colour(3));
  CHECK(image.at(37, 100) == Rgb8{});
  CHECK(image.at(36, 100) == under);
  CHECK(image.at(40, 100) == under);
  CHECK(image.at(50, 110) == id_colour(3));
  CHECK(image.at(50, 113) == under);
}
