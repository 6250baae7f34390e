// The inspection of a pile: the way through the scene and what the sonar meets on it.
#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.h"
#include "core/units.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr double kPileRadiusM = 0.45;
constexpr double kOrbitRadiusM = 3;

// From where along a ray the upright cylinder about the origin is met; infinite where it is not.
double to_cylinder_m(Vec3 from, Vec3 direction, double radius_m) {
  const double a = direction.x * direction.x + direction.y * direction.y;
  const double b = from.x * direction.x + from.y * direction.y;
  const double c = from.x * from.x + from.y * from.y - radius_m * radius_m;
  const double root = b * b - a * c;
  return root < 0 ? std::numeric_limits<double>::infinity() : (-b - std::sqrt(root)) / a;
}

// The nearest point of the pile in a beam's direction, over its whole fan in fine steps.
double expected_m(const Pose& sonar, double azimuth_rad, double fan_rad) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = -500; i <= 500; ++i) {
    const double elevation = fan_rad / 2 * i / 500;
    const Vec3 ahead{std::cos(elevation) * std::cos(azimuth_rad),
                     std::cos(elevation) * std::sin(azimuth_rad), std::sin(elevation)};
    least = std::min(least,
                     to_cylinder_m(sonar.position_m, rotate(sonar.rotation, ahead), kPileRadiusM));
  }
  return least;
}

}  // namespace

// Protects the way: once around at the orbit's distance and speed, looking inward but for the
// wave motion, whose heave is all that moves the vehicle off its circle.
TEST_CASE("the inspection goes once around the pile") {
  const SceneRun run("pile_inspection");
  const std::vector<double>& times = run.session().ping_times_s;
  CHECK(times.size() == 38);  // 2 pi 3 m at 0.5 m/s: 37.7 s
  double turned = 0, heave = 0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const Pose pose = sonar_pose(run.session(), static_cast<std::uint32_t>(k));
    const double bearing = times[k] * 0.5 / kOrbitRadiusM;
    INFO("ping " << k);
    CHECK(pose.position_m.x == Approx(3 * std::cos(bearing)).margin(1e-9));
    CHECK(pose.position_m.y == Approx(3 * std::sin(bearing)).margin(1e-9));
    const Vec3 inward{-std::cos(bearing), -std::sin(bearing), 0};
    const double off = std::acos(dot(inward, rotate(pose.rotation, {1, 0, 0})));
    // Four standard deviations of pitch and yaw together, sqrt(1 + 2.25) degrees.
    CHECK(degrees(off) < 4 * 1.81);
    turned = std::max(turned, off);
    heave = std::max(heave, std::abs(pose.position_m.z));
  }
  CHECK(degrees(turned) > 1);
  CHECK(heave > 0.08);
  CHECK(heave < 4 * 0.08);
}

// Protects pose, tracer and labels together, where nothing but the pile stands before the sonar:
// the first return of the centre beams is the pile's distance along them under the rocked
// attitude, and the nearest of all beams that of its skin from the orbit. 64 rays over 20 degrees
// miss the nearest point by at most 0.16 degrees, 1e-5 m; beam centres 0.51 degrees apart by
// 0.25 degrees, which at 2.55 m from a skin of 0.45 m radius is (2.55 * 3 / 0.45) (0.0044)^2 / 2
// = 1.7e-4 m.
TEST_CASE("the pile stands where the centre beam meets it") {
  const SceneRun run("pile_inspection");
  const Sonar& sonar = run.session().sonar;
  for (const std::uint32_t number : {10u, 12u, 25u, 27u}) {
    const PingResult ping = run.ping(number);
    double nearest = std::numeric_limits<double>::infinity();
    for (const float r : ping.first_return_m) {
      if (!std::isnan(r)) nearest = std::min(nearest, static_cast<double>(r));
    }
    INFO("ping " << number);
    CHECK(nearest == Approx(kOrbitRadiusM - kPileRadiusM).margin(2.5e-4));
    for (const int beam : {118, 127, 128, 137}) {
      const double azimuth = beam_azimuth_rad(sonar, beam);
      const double wanted = expected_m(ping.sonar_in_world, azimuth, sonar.elevation_fan_rad);
      INFO("beam " << beam);
      REQUIRE(std::isfinite(wanted));
      CHECK(ping.first_return_m[beam] == Approx(wanted).margin(5e-5));
    }
  }
}

// Protects the wave motion's place in the chain: without it a centre beam that meets the pile first
// reads the same on either side of it.
TEST_CASE("the wave motion moves the centre beam's reading", "[figure]") {
  const auto reading = [](const std::string& yaw_deg, std::uint32_t number) {
    const SceneRun run("pile_inspection", {{"trajectory.wave_motion.yaw_deg", yaw_deg},
                                           {"trajectory.wave_motion.heave_m", "0"},
                                           {"trajectory.wave_motion.pitch_deg", "0"},
                                           {"trajectory.wave_motion.roll_deg", "0"}});
    return static_cast<double>(run.ping(number).first_return_m[128]);
  };
  const double still = reading("0", 10);
  CHECK(still == Approx(reading("0", 27)).margin(1e-4));
  CHECK(still == Approx(2.55).margin(2.5e-4));
  CHECK(reading("3", 10) > still + 1e-3);
}
