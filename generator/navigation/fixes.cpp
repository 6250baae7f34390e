#include <cmath>

#include "core/navigation_tables.h"
#include "core/units.h"
#include "navigation/sensors.h"

namespace ensonify {
namespace {

// Processes of random numbers.
constexpr std::uint32_t kOfSequence = 0, kOfSample = 1, kDropped = 2;

// Semi-major axis and squared first eccentricity of WGS 84.
constexpr double kSemiMajorM = 6378137.0, kEccentricity2 = 6.69437999014e-3;

// Radius of curvature in the prime vertical.
double normal_radius_m(double latitude_rad) {
  const double sine = std::sin(latitude_rad);
  return kSemiMajorM / std::sqrt(1 - kEccentricity2 * sine * sine);
}

// Earth-centered coordinates.
Vec3 earth_centered(double latitude_rad, double longitude_rad, double altitude_m) {
  const double n_m = normal_radius_m(latitude_rad);
  const double out_m = (n_m + altitude_m) * std::cos(latitude_rad);
  return {out_m * std::cos(longitude_rad), out_m * std::sin(longitude_rad),
          (n_m * (1 - kEccentricity2) + altitude_m) * std::sin(latitude_rad)};
}

}  // namespace

void simulate_depth(const DepthSensor& depth, double density_kg_m3, const Course& course,
                    const EmitRow& row) {
  const std::uint64_t key = sensor_key(course, "depth");
  const Pose mount = mount_of(depth.mount);
  const double bias_m = depth.bias_m * normals<1>(key, kOfSequence, 0)[0];
  for_each_sample(course, depth.clock, [&](std::uint64_t sample, double time_s) {
    if (!is_kept(course, time_s)) return;
    const double z_m = compose(course.body_at(time_s), mount).position_m.z;
    const double depth_m =
        depth.surface_z_m - z_m + bias_m + depth.noise_m * normals<1>(key, kOfSample, sample)[0];
    const double values[] = {time_s, depth_m,
                             kAtmospherePa + density_kg_m3 * kGravityMS2 * depth_m};
    row(values);
  });
}

void simulate_usbl(const Usbl& usbl, const Course& course, const EmitRow& row) {
  const std::uint64_t key = sensor_key(course, "usbl");
  const Pose mount = mount_of(usbl.mount);
  const auto& [x, y, z] = usbl.transceiver_m;
  const Vec3 transceiver_m{x, y, z};
  for_each_sample(course, usbl.clock, [&](std::uint64_t sample, double time_s) {
    if (!is_kept(course, time_s)) return;
    if (uniform(key, kDropped, sample, 0) < usbl.dropped) return;
    const Vec3 place_m = compose(course.body_at(time_s), mount).position_m;
    const Vec3 way_m = place_m - transceiver_m;
    const double range_m = length(way_m);
    const Vec3 along = range_m > 0 ? (1 / range_m) * way_m : Vec3{0, 0, -1};
    const Vec3 side =
        normalized(cross(along, std::abs(along.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0}));
    const auto xi = normals<3>(key, kOfSample, sample);
    const double across_m = radians(usbl.angle_noise_deg) * range_m;
    const Vec3 fix_m = place_m + usbl.range_noise_m * xi[0] * along + across_m * xi[1] * side +
                       across_m * xi[2] * cross(along, side);
    const double values[] = {time_s, fix_m.x, fix_m.y, fix_m.z};
    row(values);
  });
}

void simulate_gps(const Gps& gps, const Course& course, const EmitRow& row) {
  const std::uint64_t key = sensor_key(course, "gps");
  const Pose mount = mount_of(gps.mount);
  for_each_sample(course, gps.clock, [&](std::uint64_t sample, double time_s) {
    if (!is_kept(course, time_s)) return;
    const Vec3 place_m = compose(course.body_at(time_s), mount).position_m;
    if (place_m.z < gps.surface_z_m) return;
    const auto xi = normals<3>(key, kOfSample, sample);
    const Geodetic fix = geodetic_of(
        gps, place_m + Vec3{gps.horizontal_noise_m * xi[0], gps.horizontal_noise_m * xi[1],
                            gps.vertical_noise_m * xi[2]});
    const double values[] = {time_s, fix.latitude_deg, fix.longitude_deg, fix.altitude_m};
    row(values);
  });
}

void simulate_odometry(const Odometry& odometry, const Course& course, const EmitRow& row) {
  const std::uint64_t key = sensor_key(course, "odometry");
  const auto constant = normals<2>(key, kOfSequence, 0);
  const double scale = 1 + odometry.scale_error_percent / 100 * constant[0];
  const double step_s = 1 / odometry.clock.rate_hz;
  const double drift_rad_s = radians(odometry.heading_drift_deg_h) / 3600 * constant[1];
  const double walk_rad = radians(odometry.heading_random_walk_deg_sqrth) / 60 * std::sqrt(step_s);
  double heading_rad = 0;
  Vec3 place_m, last_m;
  for_each_sample(course, odometry.clock, [&](std::uint64_t sample, double time_s) {
    const Vec3 true_m = course.body_at(time_s).position_m;
    if (sample == 0) {
      place_m = true_m;
    } else {
      const Vec3 step_m = true_m - last_m;
      const Quat turn = rotation_by({0, 0, heading_rad});
      place_m = place_m + rotate(turn, {scale * step_m.x, scale * step_m.y, step_m.z});
      heading_rad += drift_rad_s * step_s + walk_rad * normals<1>(key, kOfSample, sample)[0];
    }
    last_m = true_m;
    if (!is_kept(course, time_s)) return;
    const Motion motion = motion_at(course, {}, time_s);
    const Quat q = rotation_by({0, 0, heading_rad}) * motion.pose.rotation;
    const Vec3 v = scale * motion.velocity_m_s;
    const Vec3& w = motion.angular_rate_rad_s;
    const double values[] = {time_s, place_m.x, place_m.y, place_m.z, q.w, q.x, q.y,
                             q.z,    v.x,       v.y,       v.z,       w.x, w.y, w.z};
    row(values);
  });
}

Geodetic geodetic_of(const Gps& gps, Vec3 place_m) {
  const double lat = radians(gps.latitude_deg), lon = radians(gps.longitude_deg);
  const Vec3 east{-std::sin(lon), std::cos(lon), 0};
  const Vec3 up{std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)};
  const Vec3 north = cross(up, east);
  const Vec3 p = earth_centered(lat, lon, gps.altitude_m) + place_m.x * east + place_m.y * north +
                 place_m.z * up;
  // Iteration of the latitude; each step leaves less than 1 % of the error.
  const double out_m = std::hypot(p.x, p.y);
  double latitude = std::atan2(p.z, out_m * (1 - kEccentricity2));
  for (int i = 0; i < 8; ++i) {
    latitude =
        std::atan2(p.z + kEccentricity2 * normal_radius_m(latitude) * std::sin(latitude), out_m);
  }
  const double altitude_m = out_m * std::cos(latitude) + p.z * std::sin(latitude) -
                            kSemiMajorM * kSemiMajorM / normal_radius_m(latitude);
  return {degrees(latitude), degrees(std::atan2(p.y, p.x)), altitude_m};
}

}  // namespace ensonify
