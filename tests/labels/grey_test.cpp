#include "labels/grey.h"

#include <cmath>
#include <limits>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

TEST_CASE("grey is linear in dB between its limits") {
  const std::vector<float> level_db = {kNoEnergyDb, 60, 90, 120, 140};
  const GreyImage grey = grey_image(1, 5, level_db, GreyScale::db, {60, 120});
  CHECK(grey.pixels == std::vector<std::uint8_t>{0, 0, 128, 255, 255});
}

// Protects pixels without energy, which have no level: black, whatever the limits.
TEST_CASE("what has no energy is black in every scale") {
  const std::vector<float> level_db = {kNoEnergyDb, -98};
  for (const GreyScale scale : {GreyScale::db, GreyScale::amplitude}) {
    const GreyImage grey = grey_image(1, 2, level_db, scale, {-300, -98});
    CHECK(grey.pixels == std::vector<std::uint8_t>{0, 255});
  }
}

// Protects amplitude pictures: half the pressure, half the grey, and white at the upper limit.
TEST_CASE("grey is proportional to pressure where it is asked for") {
  std::vector<float> level_db;
  for (const double pressure : {1e-6, 0.1, 0.5, 1.0, 3.0}) {
    level_db.push_back(static_cast<float>(120 + 20 * std::log10(pressure)));
  }
  const GreyImage grey = grey_image(1, 5, level_db, GreyScale::amplitude, {0, 120});
  CHECK(grey.pixels == std::vector<std::uint8_t>{0, 26, 128, 255, 255});
}

// Protects the gain's formula at ranges where it is known by heart.
TEST_CASE("the shown gain grows with range as the sonar equation falls") {
  const auto gain_db = shown_gain_db({GreyScale::db, 3, 40, true}, 0.5, 0.1, 101);
  REQUIRE(gain_db.size() == 101);
  CHECK(gain_db[10] == Approx(3 + 0 + 1));     // 1 m
  CHECK(gain_db[100] == Approx(3 + 40 + 10));  // 10 m
  CHECK(gain_db[1] == Approx(3 - 40 + 0.1));   // 0.1 m
  CHECK(gain_db[0] == gain_db[1]);             // no range at all
  const auto plain = shown_gain_db({GreyScale::db, -2, 0, false}, 0.5, 0.1, 3);
  CHECK(plain == std::vector<double>{-2, -2, -2});
}

// Protects rows from each other's gain, and the mark of no energy from any.
TEST_CASE("each sample's row has its own gain") {
  const std::vector<float> level_db = {60, kNoEnergyDb, 70, 80, 90, 100};
  CHECK(with_gain(level_db, std::vector<double>{1, 10, -100}) ==
        std::vector<float>{61, kNoEnergyDb, 80, 90, -10, 0});
}

// Protects the pictures' contrast: limits span the echoes, not the silence between them.
TEST_CASE("limits follow the pixels that hold an echo") {
  std::vector<float> clean_db, elevation_rad;
  for (int i = 0; i < 1000; ++i) {
    clean_db.push_back(static_cast<float>(80 + 50 * (i / 999.0)));
    elevation_rad.push_back(0);
    clean_db.push_back(20);
    elevation_rad.push_back(std::numeric_limits<float>::quiet_NaN());
  }
  const auto limits = db_limits_from_clean(clean_db, elevation_rad);
  CHECK(limits[0] == 72);   // 82.5 - 10, rounded down
  CHECK(limits[1] == 136);  // 129.5 + 6, rounded up
  CHECK(db_limits_from_clean({}, {}) == std::array<double, 2>{60, 120});
}
