// V6: the level inside a diffuse sphere, through tracer, scatterers and synthesis.
#include <cmath>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "synthesis/backend.h"
#include "trace/scatter.h"

using namespace ensonify;

namespace {

struct SphereLevels {
  double clean_db = 0;  // of the central beam at t = 2r/c
  double mean_db = 0;   // over beams and pings
};

// b = 30 kHz in place of 29.9: the instant 2r/c then falls on a sample, and the level there does
// not depend on b. 70 beams, 8 of each ping 1.4 deg apart and away from the fan's edges.
SphereLevels levels(double radius_m, int rays_elevation, int rays_azimuth, int pings) {
  Sonar sonar = test::fan_sonar(301, radians(0.175) * 301, radius_m + 1, rays_elevation);
  sonar.bandwidth_hz = 30e3;
  sonar.rays_azimuth = rays_azimuth;
  const Water water{1500, 0};
  Material material;
  material.reflectivity = 1e-3;
  World world;
  world.objects.push_back({1, SphereShape{radius_m, true}, {}, material});
  world.instances.resize(1);
  const Tracer tracer(world);
  const Fan fan = make_fan(sonar);
  const Workers workers(2);
  const auto hits = tracer.trace_fan(fan, {}, sonar.range_max_m, workers);
  const ScattererList list = sorted_by_beam_and_delay(
      surface_scatterers(fan, hits, make_surface_scattering(sonar, water, world)), 301);
  const Record record = make_record(sonar, water, 0);
  const auto backend = make_cpu_backend({sonar, water, record});
  const int sample = static_cast<int>(std::lround(radius_m * 40));
  double power = 0;
  int count = 0;
  SphereLevels result;
  for (int ping = 0; ping < pings; ++ping) {
    const PingTask task{
        &list, {stream_key(5, Stream::speckle, 0), std::uint32_t(ping), 0, 0, 0}, 0, {}};
    PingSeries series;
    backend->synthesize({&task, 1}, {&series, 1}, workers);
    for (int beam = 46; beam < 256; beam += 8, ++count) {
      power += std::norm(
          std::complex<double>(series.pressure_pa[std::size_t(beam) * record.samples + sample]));
    }
    result.clean_db = level_db(series.clean_power_pa2[150u * record.samples + sample]);
  }
  result.mean_db = level_db(power / count);
  return result;
}

}  // namespace

// Expected S0^2 mu int B_az^2 dtheta int B_el^2 cos phi dphi / r^2 = 153.50 dB, within 0.15 dB.
// The mean over 27 beams x 300 pings = 8,100 intensities has a standard error of 0.048 dB, three
// of which are the tolerance.
TEST_CASE("V6: level inside a diffuse sphere", "[figure]") {
  const SphereLevels near = levels(5, 16, 1, 300);
  CHECK(near.clean_db == Approx(153.50).margin(0.15));
  CHECK(near.mean_db == Approx(153.50).margin(0.15));
}

TEST_CASE("V6: twice the radius is 6.02 dB less") {
  CHECK(levels(10, 16, 1, 1).clean_db - levels(5, 16, 1, 1).clean_db == Approx(-6.02).margin(0.05));
}

// Protects levels against ray density, the oldest fault of such simulators.
TEST_CASE("V6: the level does not depend on the number of rays") {
  const double few = levels(5, 10, 1, 1).clean_db;
  CHECK(levels(5, 80, 1, 1).clean_db == Approx(few).margin(0.03));
  CHECK(levels(5, 10, 8, 1).clean_db == Approx(few).margin(0.01));
}

// The same where nothing is concentric: a room, a pipe across it and a ball, mean clean power over
// the picture. Twice the rays either way move it by less than 0.1 dB.
TEST_CASE("the mean level of a room does not depend on the number of rays") {
  Sonar sonar = test::fan_sonar(64, radians(1.4) * 64, 9, 1);
  const Water water{1500, 0.3};
  Material material;
  material.reflectivity = 1e-3;
  World world;
  world.objects.push_back({1, BoxShape{{5.5, 5.5, 0.8}, true}, {}, material});
  world.objects.push_back(
      {2, CylinderShape{0.2, 1}, {{4, 0.5, 0.1}, from_roll_pitch_yaw(0.7, 0.3, 0)}, material});
  world.objects.push_back({3, SphereShape{0.3, false}, {{3, -1, -0.2}, {}}, material});
  world.instances.resize(3);
  const Tracer tracer(world);
  const Workers workers(2);
  const auto level = [&](int azimuth, int elevation) {
    sonar.rays_azimuth = azimuth;
    sonar.rays_elevation = elevation;
    const Fan fan = make_fan(sonar);
    const auto hits = tracer.trace_fan(fan, {}, sonar.range_max_m, workers);
    const ScattererList list = sorted_by_beam_and_delay(
        surface_scatterers(fan, hits, make_surface_scattering(sonar, water, world)), 64);
    const auto backend = make_cpu_backend({sonar, water, make_record(sonar, water, 0)});
    const PingTask task{&list, {}, 0, {}};
    PingSeries series;
    backend->synthesize({&task, 1}, {&series, 1}, workers);
    double sum = 0;
    for (const float power : series.clean_power_pa2) sum += power;
    return level_db(sum / double(series.clean_power_pa2.size()));
  };
  const double preset = level(1, 114);
  CHECK(level(2, 114) == Approx(preset).margin(0.1));
  CHECK(level(1, 228) == Approx(preset).margin(0.1));
}
