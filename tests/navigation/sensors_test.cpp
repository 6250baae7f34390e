#include "navigation/sensors.h"

#include <cmath>
#include <limits>
#include "catch.h"

#include "core/units.h"
#include "courses.h"

namespace ensonify {
namespace {

constexpr double kNoRange = std::numeric_limits<double>::quiet_NaN();

// A floor at z = -10 m.
double floor_range(double, Vec3 from_m, Vec3 direction, double range_max_m) {
  const double range_m = (from_m.z + 10) / -direction.z;
  return direction.z < 0 && range_m <= range_max_m ? range_m : kNoRange;
}

// Along x at 1.5 m/s, yawed by 30 degrees, and rising by 0.2 m/s.
Path sliding() {
  TrajectorySpec spec;
  const std::array<double, 3> turn{0, 0, 30};
  spec.path = std::vector<TimedPoseSpec>{{0, {{0, 0, 0}, turn}}, {10, {{15, 0, 2}, turn}}};
  return path_of(spec);
}

Dvl dvl_at(double rate_hz) {
  Dvl dvl;
  dvl.clock.rate_hz = rate_hz;
  dvl.range_max_m = 50;
  dvl.beam_angle_deg = 25;
  return dvl;
}

SensorRows rows_of(const Dvl& dvl, const Course& course,
                   const FindRange& find_range = floor_range) {
  SensorRows rows;
  simulate_dvl(dvl, course, find_range, collect(rows));
  return rows;
}

const double kAhead = 1.5 * std::cos(radians(30)), kToStarboard = 1.5 * std::sin(radians(30));

}  // namespace

TEST_CASE("a DVL has the velocity in its frame, and the ranges of the floor") {
  const Path path = sliding();
  const SensorRows rows = rows_of(dvl_at(5), course_on(path, 0, 10));
  REQUIRE(rows.size() == 51);
  for (const auto& row : rows) {
    CHECK(length(vec_at(row, 1) - Vec3{kAhead, -kToStarboard, 0.2}) < 1e-9);
    const double height_m = 10 + 0.2 * row[0];
    CHECK(row[4] == Approx(height_m).epsilon(1e-12));
    for (int k = 0; k < 4; ++k) {
      CHECK(row[5 + k] == Approx(height_m / std::cos(radians(25))).epsilon(1e-12));
    }
    // Beam 0 points ahead and to port: away from a drift to starboard.
    const double across = std::sin(radians(25)) * std::sqrt(0.5);
    CHECK(row[9] == Approx(across * (kAhead - kToStarboard) - 0.2 * std::cos(radians(25))));
  }
}

TEST_CASE("the velocity of a turning body includes the lever arm of the DVL") {
  TrajectorySpec spec;
  OrbitSpec orbit;
  orbit.radius_m = 10;
  orbit.speed_m_s = 1;
  orbit.look = OrbitLook::along;
  spec.path = orbit;
  Dvl dvl = dvl_at(2);
  dvl.mount = SensorMount{{-0.5, 0, 0}, {0, 0, 90}};
  const Path path = path_of(spec);
  // w x r: 0.1 rad/s at 0.5 m astern is 0.05 m/s to starboard; x of the DVL points to port.
  for (const auto& row : rows_of(dvl, course_on(path, 1, 9))) {
    CHECK(length(vec_at(row, 1) - Vec3{-0.05, -1, 0}) < 1e-6);
  }
}

TEST_CASE("three beams give the velocity, two do not, and ranges beyond the limits are no lock") {
  const Path path = sliding();
  const Course course = course_on(path, 0, 1);
  const auto hidden = [](int count) {
    return [count, asked = 0](double t, Vec3 from, Vec3 to, double most) mutable {
      return asked++ % 4 < count ? kNoRange : floor_range(t, from, to, most);
    };
  };
  for (const auto& row : rows_of(dvl_at(5), course, hidden(1))) {
    CHECK(length(vec_at(row, 1) - Vec3{kAhead, -kToStarboard, 0.2}) < 1e-9);
    CHECK((std::isnan(row[5]) && std::isnan(row[9]) && !std::isnan(row[6])));
  }
  for (const auto& row : rows_of(dvl_at(5), course, hidden(2))) {
    CHECK((std::isnan(row[1]) && std::isnan(row[4]) && !std::isnan(row[7])));
  }
  Dvl near = dvl_at(5);
  near.range_max_m = 11;
  Dvl far = dvl_at(5);
  far.range_min_m = 12;
  for (const Dvl& dvl : {near, far}) {
    for (const auto& row : rows_of(dvl, course)) CHECK((std::isnan(row[5]) && std::isnan(row[1])));
  }
}

// Of 4000 samples: the relative standard error of a variance is sqrt(2 / 4000) = 2.2 %.
TEST_CASE("noise of beams spreads to velocities as least squares say") {
  Dvl dvl = dvl_at(100);
  dvl.velocity_noise_m_s = 0.02;
  dvl.range_noise_percent = 1;
  const Path path = at_rest();
  double x2 = 0, z2 = 0, range2 = 0;
  const SensorRows rows = rows_of(dvl, course_on(path, 0, 39.99));
  REQUIRE(rows.size() == 4000);
  for (const auto& row : rows) {
    x2 += row[1] * row[1] / 4000;
    z2 += row[3] * row[3] / 4000;
    range2 += std::pow(row[5] / (10 / std::cos(radians(25))) - 1, 2) / 4000;
  }
  const double sine = std::sin(radians(25)), cosine = std::cos(radians(25));
  CHECK(x2 / (4e-4 / (2 * sine * sine)) == Approx(1).margin(0.067));
  CHECK(z2 / (4e-4 / (4 * cosine * cosine)) == Approx(1).margin(0.067));
  CHECK(range2 / 1e-4 == Approx(1).margin(0.067));
}

TEST_CASE("an altimeter looks along -z of its mount") {
  Altimeter altimeter;
  altimeter.clock.rate_hz = 1;
  altimeter.range_max_m = 30;
  SensorRows down, tilted;
  const Path path = sliding();
  simulate_altimeter(altimeter, course_on(path, 0, 3), floor_range, collect(down));
  altimeter.mount = SensorMount{{0, 0, 0.5}, {0, 60, 0}};
  simulate_altimeter(altimeter, course_on(path, 0, 3), floor_range, collect(tilted));
  REQUIRE(down.size() == 4);
  CHECK(down[2][1] == Approx(10.4).epsilon(1e-12));
  CHECK(tilted[2][1] == Approx(2 * 10.9).epsilon(1e-12));
}

TEST_CASE("depth and pressure count from the surface") {
  DepthSensor depth;
  depth.clock.rate_hz = 1;
  depth.surface_z_m = 3;
  depth.mount = SensorMount{{0, 0, -1}, {}};
  SensorRows rows;
  simulate_depth(depth, 1025, course_on(sliding(), 0, 2), collect(rows));
  REQUIRE(rows.size() == 3);
  CHECK(rows[1][1] == Approx(3.8).epsilon(1e-12));
  CHECK(rows[1][2] == Approx(101325 + 1025 * 9.80665 * 3.8).epsilon(1e-12));
}

// The target is at (0, 0, -100) from the transceiver. 4000 fixes less the dropped ones: relative
// standard errors of the variances 2.5 %; of the share 0.6 %.
TEST_CASE("USBL fixes spread along and across the line of sight") {
  Usbl usbl;
  usbl.clock.rate_hz = 10;
  usbl.transceiver_m = {0, 0, 100};
  usbl.range_noise_m = 0.1;
  usbl.angle_noise_deg = 0.5;
  usbl.dropped = 0.2;
  SensorRows rows;
  const Path path = at_rest();
  simulate_usbl(usbl, course_on(path, 0, 399.95), collect(rows));
  const auto count = static_cast<double>(rows.size());
  CHECK(count / 4000 == Approx(0.8).margin(0.019));
  double x2 = 0, y2 = 0, z2 = 0;
  for (const auto& row : rows) {
    x2 += row[1] * row[1] / count;
    y2 += row[2] * row[2] / count;
    z2 += row[3] * row[3] / count;
  }
  const double across = radians(0.5) * 100;
  CHECK(x2 / (across * across) == Approx(1).margin(0.075));
  CHECK(y2 / (across * across) == Approx(1).margin(0.075));
  CHECK(z2 / 0.01 == Approx(1).margin(0.075));
}

// Against the coordinates that WGS 84 defines: geodetic to earth-centered.
TEST_CASE("GPS fixes are geodetic, and only above the surface") {
  Gps gps;
  gps.clock.rate_hz = 1;
  gps.latitude_deg = -33.8;
  gps.longitude_deg = 151.2;
  gps.altitude_m = 20;
  const auto earth = [](double latitude_deg, double longitude_deg, double altitude_m) {
    const double a = 6378137, f = 1 / 298.257223563, e2 = f * (2 - f);
    const double p = radians(latitude_deg), l = radians(longitude_deg);
    const double n = a / std::sqrt(1 - e2 * std::sin(p) * std::sin(p));
    return Vec3{(n + altitude_m) * std::cos(p) * std::cos(l),
                (n + altitude_m) * std::cos(p) * std::sin(l),
                (n * (1 - e2) + altitude_m) * std::sin(p)};
  };
  const double p = radians(gps.latitude_deg), l = radians(gps.longitude_deg);
  const Vec3 east{-std::sin(l), std::cos(l), 0};
  const Vec3 north{-std::sin(p) * std::cos(l), -std::sin(p) * std::sin(l), std::cos(p)};
  const Vec3 up{std::cos(p) * std::cos(l), std::cos(p) * std::sin(l), std::sin(p)};
  for (const Vec3 place : {Vec3{0, 0, 0}, Vec3{5000, -7000, -30}, Vec3{-60000, 80000, 100}}) {
    const Geodetic fix = geodetic_of(gps, place);
    const Vec3 expected = earth(-33.8, 151.2, 20) + place.x * east + place.y * north + place.z * up;
    CHECK(length(earth(fix.latitude_deg, fix.longitude_deg, fix.altitude_m) - expected) < 1e-6);
  }
  gps.surface_z_m = 1;  // the body reaches it after 5 s
  SensorRows rows;
  simulate_gps(gps, course_on(sliding(), 0, 10), collect(rows));
  REQUIRE(rows.size() == 6);
  CHECK(rows[0][0] == 5);
}

TEST_CASE("odometry without errors is the path") {
  Odometry odometry;
  odometry.clock.rate_hz = 10;
  const Path path = sliding();
  SensorRows rows;
  simulate_odometry(odometry, course_on(path, 0, 10), collect(rows));
  REQUIRE(rows.size() == 101);
  for (const auto& row : rows) {
    CHECK(length(vec_at(row, 1) - Vec3{1.5 * row[0], 0, 0.2 * row[0]}) < 1e-9);
    CHECK(length(vec_at(row, 8) - Vec3{kAhead, -kToStarboard, 0.2}) < 1e-9);
    CHECK(row[4] == Approx(std::cos(radians(15))).epsilon(1e-12));
  }
}

// 500 runs: relative standard error of a variance sqrt(2 / 500) = 6.3 %. With the heading off by
// b t, a straight line of 15 m in 10 s ends 15 b 10 / 2 aside (smaller angles; steps of 0.5 s take
// 5 % off).
TEST_CASE("odometry drifts by scale, heading drift and heading random walk") {
  const Path path = sliding();
  const auto spread = [&](const Odometry& odometry) {
    Vec3 sum;
    double heading2 = 0;
    for (std::uint64_t key = 0; key < 500; ++key) {
      SensorRows rows;
      Course course = course_on(path, 0, 10, key);
      course.from_s = 10;
      simulate_odometry(odometry, course, collect(rows));
      REQUIRE(rows.size() == 1);
      const Vec3 off = vec_at(rows[0], 1) - Vec3{15, 0, 2};
      sum = sum + (1.0 / 500) * Vec3{off.x * off.x, off.y * off.y, off.z * off.z};
      const double heading = 2 * std::atan2(rows[0][7], rows[0][4]) - radians(30);
      heading2 += heading * heading / 500;
    }
    return std::pair(sum, heading2);
  };
  Odometry scaled, drifting, walking;
  scaled.clock.rate_hz = drifting.clock.rate_hz = walking.clock.rate_hz = 2;
  scaled.scale_error_percent = 1;
  drifting.heading_drift_deg_h = 360;
  walking.heading_random_walk_deg_sqrth = 60;
  const auto [scale2, no_heading] = spread(scaled);
  CHECK(scale2.x / (0.15 * 0.15) == Approx(1).margin(0.19));
  CHECK(length(Vec3{0, scale2.y, scale2.z}) < 1e-18);
  CHECK(no_heading < 1e-18);
  const auto [drift2, heading2] = spread(drifting);
  const double angle = radians(0.1) * 10;
  CHECK(heading2 / (angle * angle) == Approx(1).margin(0.19));
  CHECK(drift2.y / std::pow(15 * angle / 2 * 0.95, 2) == Approx(1).margin(0.2));
  CHECK(spread(walking).second / (radians(1) * radians(1) * 10) == Approx(1).margin(0.19));
}

}  // namespace ensonify
