#include <cmath>
#include <limits>

#include "core/navigation_tables.h"
#include "core/units.h"
#include "navigation/sensors.h"

namespace ensonify {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Processes of random numbers.
constexpr std::uint32_t kScale = 0, kRanges = 1, kVelocities = 2;

struct DvlPing {
  std::array<bool, 4> locked{};
  std::array<double, 4> range_m{kNone, kNone, kNone, kNone};
  std::array<double, 4> velocity_m_s{kNone, kNone, kNone, kNone};
};

// Velocity in the frame of the DVL and altitude, NaN with fewer than three beams.
std::array<double, 4> solve(const DvlPing& ping, const std::array<Vec3, 4>& beams) {
  int count = 0;
  Vec3 sum;
  double altitude_m = 0;
  for (std::size_t k = 0; k < beams.size(); ++k) {
    if (!ping.locked[k]) continue;
    ++count;
    sum = sum + ping.velocity_m_s[k] * beams[k];
    altitude_m -= ping.range_m[k] * beams[k].z;
  }
  if (count < 3) return {kNone, kNone, kNone, kNone};
  const DvlNormal inverse = inverse_normal(beams, ping.locked);
  return {dot(inverse[0], sum), dot(inverse[1], sum), dot(inverse[2], sum), altitude_m / count};
}

bool is_within(double range_m, double least_m, double most_m) {
  return range_m >= least_m && range_m <= most_m;  // false for NaN
}

}  // namespace

void simulate_dvl(const Dvl& dvl, const Course& course, const FindRange& find_range,
                  const EmitRow& row) {
  const std::uint64_t key = sensor_key(course, "dvl");
  const Pose mount = mount_of(dvl.mount);
  const std::array<Vec3, 4> beams = dvl_beams(dvl);
  const double scale = 1 + dvl.scale_error_percent / 100 * normals<1>(key, kScale, 0)[0];
  for_each_sample(course, dvl.clock, [&](std::uint64_t sample, double time_s) {
    if (!is_kept(course, time_s)) return;
    const Motion motion = motion_at(course, mount, time_s);
    const auto range_noise = normals<4>(key, kRanges, sample);
    const auto velocity_noise = normals<4>(key, kVelocities, sample);
    DvlPing ping;
    for (std::size_t k = 0; k < beams.size(); ++k) {
      const double range_m = find_range(time_s, motion.pose.position_m,
                                        rotate(motion.pose.rotation, beams[k]), dvl.range_max_m);
      ping.locked[k] = is_within(range_m, dvl.range_min_m, dvl.range_max_m);
      if (!ping.locked[k]) continue;
      ping.range_m[k] = range_m * (1 + dvl.range_noise_percent / 100 * range_noise[k]);
      ping.velocity_m_s[k] =
          scale * dot(motion.velocity_m_s, beams[k]) + dvl.velocity_noise_m_s * velocity_noise[k];
    }
    const auto [vx, vy, vz, altitude_m] = solve(ping, beams);
    const auto& r = ping.range_m;
    const auto& v = ping.velocity_m_s;
    const double values[] = {time_s, vx,   vy,   vz,   altitude_m, r[0], r[1],
                             r[2],   r[3], v[0], v[1], v[2],       v[3]};
    row(values);
  });
}

void simulate_altimeter(const Altimeter& altimeter, const Course& course,
                        const FindRange& find_range, const EmitRow& row) {
  const std::uint64_t key = sensor_key(course, "altimeter");
  const Pose mount = mount_of(altimeter.mount);
  for_each_sample(course, altimeter.clock, [&](std::uint64_t sample, double time_s) {
    if (!is_kept(course, time_s)) return;
    const Pose pose = compose(course.body_at(time_s), mount);
    double range_m = find_range(time_s, pose.position_m, rotate(pose.rotation, {0, 0, -1}),
                                altimeter.range_max_m);
    if (is_within(range_m, altimeter.range_min_m, altimeter.range_max_m)) {
      range_m += altimeter.noise_m * normals<1>(key, kRanges, sample)[0];
    } else {
      range_m = kNone;
    }
    const double values[] = {time_s, range_m};
    row(values);
  });
}

}  // namespace ensonify
