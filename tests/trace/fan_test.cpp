#include "trace/fan.h"

#include <cmath>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

// Protects levels against ray counts: cells tile each sector without gap or overlap, with the
// exact solid angle of the fan.
TEST_CASE("the fan tiles its sectors") {
  Sonar sonar;
  sonar.beam_count = 10;
  sonar.beam_spacing_rad = radians(2);
  sonar.elevation_fan_rad = radians(20);
  sonar.rays_azimuth = GENERATE(1, 3, 4);
  sonar.rays_elevation = GENERATE(1, 7);
  const Fan fan = make_fan(sonar);
  double sum = 0;
  for (const double angle : fan.solid_angle_sr) sum += angle * fan.azimuth_rad.size();
  CHECK(sum == Approx(radians(20) * 2 * std::sin(radians(10))).epsilon(1e-12));
  for (int j = 0; j < 10; ++j) {
    for (int a = 0; a < sonar.rays_azimuth; ++a) {
      CHECK(sector_of(sonar, fan.azimuth_rad[j * sonar.rays_azimuth + a]) == j);
    }
  }
  CHECK(fan.elevation_rad.front() ==
        Approx(radians(-10 + 10.0 / sonar.rays_elevation)).margin(1e-15));
  CHECK(ray_index(fan, 9, sonar.rays_azimuth - 1, sonar.rays_elevation - 1) == fan.size() - 1);
}
