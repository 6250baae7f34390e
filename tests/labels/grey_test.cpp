#include "labels/grey.h"

#include <limits>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

TEST_CASE("grey is linear in dB between its limits") {
  LabelledImage image;
  image.rows = 1;
  image.columns = 5;
  image.level_db = {kNoEnergyDb, 60, 90, 120, 140};
  const GreyImage grey = grey_image(image, {60, 120});
  CHECK(grey.pixels == std::vector<std::uint8_t>{0, 0, 128, 255, 255});
}

// Protects the pictures' contrast: limits span the echoes, not the silence between them.
TEST_CASE("limits follow the pixels that hold an echo") {
  LabelledImage polar;
  for (int i = 0; i < 1000; ++i) {
    polar.clean_db.push_back(static_cast<float>(80 + 50 * (i / 999.0)));
    polar.elevation_rad.push_back(0);
    polar.clean_db.push_back(20);
    polar.elevation_rad.push_back(std::numeric_limits<float>::quiet_NaN());
  }
  const auto limits = db_limits_from_clean(polar);
  CHECK(limits[0] == 72);   // 82.5 - 10, rounded down
  CHECK(limits[1] == 136);  // 129.5 + 6, rounded up
  CHECK(db_limits_from_clean(LabelledImage{}) == std::array<double, 2>{60, 120});
}
