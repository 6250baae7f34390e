#include "acoustics/scattering.h"

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

// Protects levels against ray density: cells add up to the whole solid angle, 4 pi for a sphere.
TEST_CASE("cells of the fan tile the sphere") {
  double sum = 0;
  const int azimuths = 90, elevations = 45;
  for (int e = 0; e < elevations; ++e) {
    const double low = -kPi / 2 + e * kPi / elevations;
    sum += azimuths * cell_solid_angle_sr(2 * kPi / azimuths, low, low + kPi / elevations);
  }
  CHECK(sum == Approx(4 * kPi).epsilon(1e-12));
}

TEST_CASE("Lambert variance follows exponent and range") {
  CHECK(lambert_variance_m2(1e-3, 0.5, 1, 2, 0.1) == Approx(1e-3 * 0.5 * 4 * 0.1));
  CHECK(lambert_variance_m2(1e-3, 0.5, 2, 2, 0.1) == Approx(1e-3 * 0.25 * 4 * 0.1));
  CHECK(lambert_variance_m2(1e-3, 0, 0, 2, 0.1) == Approx(1e-3 * 4 * 0.1));
  CHECK(target_amplitude_m(-40) == Approx(0.01));
}
