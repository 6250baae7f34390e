#include "labels/display.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

using Grays = std::vector<std::uint8_t>;

// One sample, no gain that grows with range unless the display has one.
DisplayedImage shown(const Display& display, const std::vector<float>& level_db) {
  const std::vector<float> elevation_rad(level_db.size(), 0);
  return displayed(display_table(display, 0, 1, 1), 1, static_cast<int>(level_db.size()), level_db,
                   elevation_rad);
}

Display amplitude(double gamma, double white_db = 120) {
  Display display;
  display.scale = GreyScale::amplitude;
  display.gamma = gamma;
  display.limits_db = {0, white_db};
  return display;
}

}  // namespace

// Protects the table of steps: the rounded formula, at every level that an EXR file can hold but
// for ties, which rounding decides.
TEST_CASE("gray levels are those of the formula at every level") {
  std::vector<float> level_db;
  for (int i = -90 * 16; i < 200 * 16; ++i) level_db.push_back(static_cast<float>(i) / 16);
  Display plain;
  plain.limits_db = {53, 131};
  plain.gain_db = 0.3;
  for (const Display& display : {plain, amplitude(1), amplitude(0.4, 111)}) {
    const Grays pixels = shown(display, level_db).grey.pixels;
    const auto [black, white] = display.limits_db;
    int largest = 0, different = 0, ties = 0;
    for (std::size_t i = 0; i < level_db.size(); ++i) {
      const double s = level_db[i] + display.gain_db;
      const double gray = display.scale == GreyScale::db
                              ? 255 * (s - black) / (white - black)
                              : 255 * std::pow(10.0, display.gamma * (s - white) / 20);
      const double rounded = std::floor(std::clamp(gray, 0.0, 255.0) + 0.5);
      const bool is_tie = std::abs(gray - std::floor(gray) - 0.5) < 1e-9;
      ties += is_tie;
      different += !is_tie && rounded != pixels[i];
      largest = std::max<int>(largest, pixels[i]);
    }
    CHECK(different == 0);
    CHECK(ties < 20);  // of 4,640 levels
    CHECK(largest == 255);
  }
}

// Protects pixels without energy, which have no level: black, whatever the limits.
TEST_CASE("what has no energy is black in every scale") {
  Display plain;
  plain.limits_db = {-300, -98};
  for (const Display& display : {plain, amplitude(1, -98)}) {
    CHECK(shown(display, {kNoEnergyDb, -98}).grey.pixels == Grays{0, 255});
  }
}

// Protects the gain's formula at ranges where it is known by heart.
TEST_CASE("the time-varied gain grows with range as the sonar equation falls") {
  Display display;
  display.spreading = 40;
  display.absorption = true;
  const auto tvg_db = display_table(display, 0.5, 0.1, 101).tvg_db;
  REQUIRE(tvg_db.size() == 101);
  CHECK(tvg_db[10] == Approx(0 + 1));     // 1 m
  CHECK(tvg_db[100] == Approx(40 + 10));  // 10 m
  CHECK(tvg_db[1] == Approx(-40 + 0.1));  // 0.1 m
  CHECK(tvg_db[0] == tvg_db[1]);          // no range at all
  CHECK(display_table({}, 0.5, 0.1, 3).tvg_db == std::vector<double>{0, 0, 0});
}

// Protects rows from each other's gain, and the mark of no energy from any.
TEST_CASE("each sample's row has its own gain") {
  Display display;
  display.limits_db = {0, 255};  // a gray level a dB
  display.spreading = 10;
  const auto table = display_table(display, 0, 10, 3);
  const std::vector<float> three = {60, kNoEnergyDb, 70, 80, 90, 100}, of_three(6, 0);
  CHECK(displayed(table, 3, 2, three, of_three).grey.pixels == Grays{70, 0, 80, 90, 103, 113});
}

// Protects images of pings of any loudness: the same speckle gets the same gray, and the rank that
// the documents name lands on white.
TEST_CASE("automatic gain takes a ping's loudness out") {
  std::vector<float> level_db = {kNoEnergyDb, kNoEnergyDb};
  for (int i = 0; i < 1000; ++i) level_db.push_back(static_cast<float>((i * 7 % 1000) / 16.0));
  Display display;
  display.limits_db = {60, 120};
  display.automatic_gain = true;
  const Grays quiet = shown(display, level_db).grey.pixels;
  for (float& level : level_db) level = level > kNoEnergyDb ? level + 32 : level;
  CHECK(shown(display, level_db).grey.pixels == quiet);
  // Levels from 0 to 62.4375 in sixteenths of a dB: that of rank 994 becomes 120 dB. White are
  // those within half a gray level, 60 / 510 dB, of it: ranks 993 to 999.
  CHECK(std::count(quiet.begin(), quiet.end(), 255) == 7);
  display.gain_db = -6;
  const Grays dimmed = shown(display, level_db).grey.pixels;
  CHECK(*std::max_element(dimmed.begin(), dimmed.end()) == 231);  // (120 - 6 + 5 / 16 - 60) / 60
}

// Protects the warning of a display that does not fit: what it counts.
TEST_CASE("white and black pixels are counted, black ones where there is an echo") {
  const float none = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> level_db = {kNoEnergyDb, 40, 40, 90, 130, 130};
  const std::vector<float> elevation_rad = {none, none, 0, 0, 0, none};
  const auto image = displayed(display_table({}, 0, 1, 2), 2, 3, level_db, elevation_rad);
  CHECK(image.counts == DisplayCounts{6, 2, 3, 1});
}

// Protects the images' contrast: limits span the echoes, not the silence between them.
TEST_CASE("limits follow the pixels that hold an echo") {
  std::vector<float> clean_db, elevation_rad;
  for (int i = 0; i < 1000; ++i) {
    clean_db.push_back(static_cast<float>(80 + 50 * (i / 999.0)));
    elevation_rad.push_back(0);
    clean_db.push_back(20);
    elevation_rad.push_back(std::numeric_limits<float>::quiet_NaN());
  }
  // At one dB less more than 0.2 % of the 2,000 pixels are white.
  double white = 150;
  const auto whites = [&](double limit_db) {
    double sum = 0;
    for (std::size_t i = 0; i < clean_db.size(); i += 2) {
      sum += std::exp(-std::pow(10.0, (limit_db - clean_db[i]) / 10));
    }
    return sum;
  };
  while (whites(white - 1) <= 0.002 * 2000) --white;
  const auto limits = db_limits_from_clean(clean_db, elevation_rad);
  CHECK(limits[0] == 67);  // 82.5 - 15, rounded down
  CHECK(limits[1] == white);
  CHECK(db_limits_from_clean({}, {}) == std::array<double, 2>{60, 120});
}

// Protects the share of white pixels: speckle over one mean level reaches the white limit as often
// as is allowed for, 0.2 % of the pixels. 10^(w / 10) = ln(500) times the mean: 7.93 dB over it.
TEST_CASE("speckle reaches the white limit in few pixels") {
  const auto limits = default_limits_db({std::vector<float>(1000, 100.0f), 1000});
  CHECK(limits == std::array<double, 2>{63, 108});  // 45 dB at least
}

// Protects scenes with few echoes from the loudest of them: a glint in an empty tank does not make
// its walls black. A tenth of the echoes may be white.
TEST_CASE("a few loud pixels do not darken the others") {
  EchoLevels levels{std::vector<float>(9200, 100.0f), 1'000'000};
  levels.db.resize(10'000, 150.0f);
  const auto [black, white] = default_limits_db(levels);
  CHECK(white < 108);
  CHECK(black > 60);
  levels.pixels = 10'000;  // the same echoes everywhere: the bright ones are no small part
  CHECK(default_limits_db(levels)[1] > 150);
}

// Protects scenes in noise: echoes that it hides have no part in the limits.
TEST_CASE("limits follow the echoes that are louder than the noise") {
  LabelledImage polar;
  polar.rows = 1;
  polar.columns = 4;
  polar.clean_db = {50, 70, 90, 100};
  polar.elevation_rad = {0, 0, 0, std::numeric_limits<float>::quiet_NaN()};
  const auto table = display_table({}, 0, 1, 1);
  CHECK(echo_levels(table, polar, 0).db == std::vector<float>{50, 70, 90});
  CHECK(echo_levels(table, polar, mean_square_pa2(69)).db == std::vector<float>{70, 90});
  CHECK(echo_levels(table, polar, mean_square_pa2(95)).db == std::vector<float>{50, 70, 90});
  CHECK(echo_levels(table, polar, 0).pixels == 4);
}

// Protects default limits from a display's constant gain, which would cancel itself.
TEST_CASE("levels for limits have the time-varied gain and no other") {
  Display display;
  display.spreading = 20;
  display.gain_db = 11;
  LabelledImage polar;
  polar.rows = 2;
  polar.columns = 1;
  polar.clean_db = {50, 60};
  polar.elevation_rad = {0, 0};
  CHECK(echo_levels(display_table(display, 0, 10, 2), polar, 0).db == std::vector<float>{70, 80});
}
