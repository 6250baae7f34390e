#include "acoustics/water.h"

#include "catch.h"

using namespace ensonify;

// V9: Francois-Garrison absorption at 10 C, 35 psu, pH 8 at the surface.
TEST_CASE("V9: absorption of sea water") {
  const SeaWater water{10, 35, 8, 0};
  CHECK(francois_garrison_db_m(100e3, water) == Approx(0.0336).epsilon(0.01));
  CHECK(francois_garrison_db_m(400e3, water) == Approx(0.0961).epsilon(0.01));
  CHECK(francois_garrison_db_m(900e3, water) == Approx(0.2995).epsilon(0.01));
  CHECK(francois_garrison_db_m(1200e3, water) == Approx(0.4954).epsilon(0.01));
  CHECK(francois_garrison_db_m(2100e3, water) == Approx(1.4186).epsilon(0.01));
}

// Protects against a slip in a term that the table above does not feel: fresh water loses the
// salts' part, depth lowers absorption, and both branches of the water term meet at 20 C.
TEST_CASE("absorption follows salinity, depth and temperature") {
  CHECK(francois_garrison_db_m(100e3, {10, 0, 7, 0}) == Approx(3.09e-4 * 10).epsilon(0.02));
  CHECK(francois_garrison_db_m(400e3, {10, 35, 8, 2000}) <
        francois_garrison_db_m(400e3, {10, 35, 8, 0}));
  CHECK(francois_garrison_db_m(900e3, {20, 35, 8, 0}) ==
        Approx(francois_garrison_db_m(900e3, {20.0001, 35, 8, 0})).epsilon(0.005));
}
