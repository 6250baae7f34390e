// Protects: elastic bodies as objects. Their sums against the form functions, what hides them, and
// that a cylinder off broadside falls off as its length says.

#include <cmath>
#include <complex>

#include "acoustics/elastic_body.h"
#include "catch.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "trace/plain_world.h"
#include "trace/scatter.h"
#include "trace/scene.h"

namespace ensonify {
namespace {

const Water kRingingWater{1500, 0};

Sonar ringing_sonar() { return test::fan_sonar(60, radians(60), 12, 20, radians(60)); }

// The taps state the response of an echo from the front of a body of 0.05 m.
const std::vector<Tap> kTwoTaps = {{-2 * 0.05 / 1500, {0.3, 0.1}}, {1e-5, {0, -0.05}}};

World ringing_world(Shape shape, Pose pose) {
  World world = world_with(std::move(shape), pose);
  world.objects[0].ringing.taps = kTwoTaps;
  return world;
}

std::vector<Scatterer> ringing_echoes(const World& world, int threads = 1,
                                      std::vector<HiddenTarget>* hidden = nullptr) {
  const std::vector<Pose> poses = own_poses(world);
  const Tracer tracer(world);
  return elastic_scatterers({world, tracer, poses, {}}, ringing_sonar(), kRingingWater,
                            Workers(threads), hidden);
}

std::complex<double> of_taps(double f_hz) {
  std::complex<double> sum = 0;
  for (const Tap& tap : kTwoTaps) sum += tap.gain * std::polar(1.0, -2 * kPi * f_hz * tap.delay_s);
  return sum;
}

TEST_CASE("an elastic sphere is one echo for each tap, at its center") {
  const auto scatterers = ringing_echoes(ringing_world(SphereShape{0.05, false}, {{4, 0.5, 0.2}, {}}));
  REQUIRE(scatterers.size() == 2);
  const double range = length(Vec3{4, 0.5, 0.2});
  for (const double f : {890e3, 905e3}) {
    const std::complex<double> expected =
        of_taps(f) / (range * range) * std::polar(1.0, -4 * kPi * f * range / 1500);
    CHECK(std::abs(sum_of_echoes(scatterers, f, 0) - expected) < 1e-4 * std::abs(expected));
  }
  CHECK(scatterers[0].key != scatterers[1].key);
  CHECK(scatterers[0].instance == 1);
}

// The integral along the axis of spherical waves with the response of each element.
TEST_CASE("an elastic cylinder is the integral along its axis, broadside and tilted") {
  // Pieces of c/24b = 2.1 mm would have a lobe at 23.6 degrees without their directivity.
  for (const double tilt_deg : {0.0, 1.0, 4.0, 23.6, 60.0}) {
    const double half = 0.3, tilt = radians(tilt_deg);
    const Pose pose{{4, 0, 0}, {std::cos(tilt / 2), 0, std::sin(tilt / 2), 0}};
    const auto scatterers = ringing_echoes(ringing_world(CylinderShape{0.05, half}, pose));
    const double f = 900e3;
    std::complex<double> expected = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double z = half * ((2 * i + 1.0) / kSteps - 1);
      const double r = length(transform_point(pose, {0, 0, z}));
      expected += std::polar(1 / (r * r), -4 * kPi * f * r / 1500) * (2 * half / kSteps);
    }
    expected *= of_taps(f);
    CAPTURE(tilt_deg);
    CHECK(std::abs(sum_of_echoes(scatterers, f, 0) - expected) < 0.02 * std::abs(expected) + 2e-4);
  }
}

TEST_CASE("another body hides an elastic one, and threads change nothing") {
  World world = ringing_world(CylinderShape{0.05, 0.2}, {{4, 0, 0}, {}});
  const auto seen = ringing_echoes(world);
  const auto again = ringing_echoes(world, 3);
  REQUIRE(seen.size() == again.size());
  CHECK(seen.size() > 40);
  for (std::size_t i = 0; i < seen.size(); ++i) CHECK(seen[i].key == again[i].key);
  // The lower half of the axis.
  add_object(world, BoxShape{{0.01, 1, 0.5}, false}, {{2, 0, -0.5}, {}});
  const auto upper = ringing_echoes(world);
  CHECK(upper.size() == Approx(seen.size() / 2.0).margin(4));
  for (const Scatterer& s : upper) CHECK(s.position_m.z > 0);
  world.objects[1].pose.position_m.z = 0;
  std::vector<HiddenTarget> hidden;
  CHECK(ringing_echoes(world, 2, &hidden).empty());
  REQUIRE(hidden.size() == seen.size());
  for (const HiddenTarget& target : hidden) CHECK(target.occluder == 2);
}

}  // namespace
}  // namespace ensonify
