#include "ping/navigation_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "navigation/tables.h"

namespace ensonify {
namespace {

// The end of the rows for pings before `last_ping`. An instrument of a rig has sensors alone, whose
// rows fill the time up to its next ping, or to the end of the run.
double end_s(const Session& session, std::uint32_t last_ping) {
  const auto& times_s = session.ping_times_s;
  const double last_s = times_s[last_ping - 1];
  if (instrument_kind(session.scenario) != InstrumentKind::navigation) return last_s;
  if (last_ping < times_s.size()) return std::nextafter(times_s[last_ping], last_s);
  const TrajectorySpec& trajectory = session.scenario.trajectory;
  const auto [start_s, stop_s] = span_of(session.path);
  double next_s = last_s + 1 / ping_rate_hz(session.scenario);
  if (trajectory.pings) {
    next_s = std::min(next_s, start_s + *trajectory.pings / trajectory.ping_rate_hz);
  }
  next_s = std::nextafter(next_s, last_s);
  return start_s == stop_s ? next_s : std::min(next_s, stop_s);
}

Course course_of(const Session& session, const SequenceInfo& info) {
  const auto& times_s = session.ping_times_s;
  Course course;
  course.body_at = [&session](double time_s) { return pose_at(session.path, time_s); };
  course.span = span_of(session.path);
  course.start_s = times_s.front();
  course.from_s = times_s[info.first_ping];
  course.to_s = info.last_ping > info.first_ping ? end_s(session, info.last_ping) : course.from_s;
  course.key = stream_key(session.scenario.seed, Stream::navigation,
                          SequenceDraw(info.sequence, session.scenario.redraw));
  return course;
}

double range_along(const Tracer& scene, Vec3 from_m, Vec3 direction, double range_max_m) {
  const Hit hit = scene.first_hit({from_m, direction}, range_max_m);
  return hit.instance == 0 ? std::numeric_limits<double>::quiet_NaN() : hit.range_m;
}

// The sensors by name, with their clocks and about how long a row is.
struct SensorRows {
  const char* name;
  SensorClock clock;
  double bytes;
};

std::vector<SensorRows> sensors_of(const Navigation& navigation) {
  std::vector<SensorRows> sensors;
  const auto add = [&](const char* name, const auto& sensor, double bytes) {
    if (sensor) sensors.push_back({name, sensor->clock, bytes});
  };
  add("imu", navigation.imu, 460);
  add("dvl", navigation.dvl, 240);
  add("depth", navigation.depth, 50);
  add("altimeter", navigation.altimeter, 30);
  add("usbl", navigation.usbl, 70);
  add("gps", navigation.gps, 70);
  add("odometry", navigation.odometry, 270);
  return sensors;
}

// Samples in all pings.
double samples_of(const Session& session, const SensorClock& clock) {
  const auto& times_s = session.ping_times_s;
  const double span_s = end_s(session, static_cast<std::uint32_t>(times_s.size())) - times_s[0];
  const double first = std::max(0.0, std::ceil(-clock.time_offset_s * clock.rate_hz));
  return std::max(0.0, std::floor((span_s - clock.time_offset_s) * clock.rate_hz) + 1 - first);
}

bool dvl_has_lock(const Dvl& dvl, const Tracer& scene, const Pose& body) {
  const Pose pose = compose(body, mount_of(dvl.mount));
  return std::ranges::any_of(dvl_beams(dvl), [&](const Vec3& beam) {
    return range_along(scene, pose.position_m, rotate(pose.rotation, beam), dvl.range_max_m) >=
           dvl.range_min_m;
  });
}

bool altimeter_has_echo(const Altimeter& altimeter, const Tracer& scene, const Pose& body) {
  const Pose pose = compose(body, mount_of(altimeter.mount));
  return range_along(scene, pose.position_m, rotate(pose.rotation, {0, 0, -1}),
                     altimeter.range_max_m) >= altimeter.range_min_m;
}

}  // namespace

WriteTables write_sensor_tables(const Session& session, const Tracer& tracer,
                                const SequenceInfo& info) {
  if (!info.navigation) return {};
  return [&session, &tracer, &info](const auto& append) {
    // Samples come in the order of time, so that a scene serves all rays of a sample.
    std::optional<Tracer> scene;
    double scene_s = 0;
    const FindRange find_range = [&](double time_s, Vec3 from_m, Vec3 direction, double most_m) {
      if (!scene || scene_s != time_s) scene = tracer.at(object_poses_at(session, time_s));
      scene_s = time_s;
      return range_along(*scene, from_m, direction, most_m);
    };
    write_navigation(info.navigation->sensors,
                     {course_of(session, info), find_range, session.water.density_kg_m3}, append);
  };
}

Status check_navigation(const Session& session) {
  if (!session.scenario.navigation) return {};
  for (const SensorRows& sensor : sensors_of(*session.scenario.navigation)) {
    const double samples = samples_of(session, sensor.clock);
    if (samples <= kMostSensorRows) continue;
    return Error{ErrorKind::usage,
                 fmt::format("navigation.{}.rate_hz: gives {:.2g} samples in a sequence; expected "
                             "{:g} at most, by a lower rate or a shorter path",
                             sensor.name, samples, kMostSensorRows)};
  }
  return {};
}

std::vector<std::string> navigation_warnings(const Session& session, const Tracer& tracer) {
  const auto& navigation = session.scenario.navigation;
  if (!navigation) return {};
  std::vector<std::string> warnings;
  for (const SensorRows& sensor : sensors_of(*navigation)) {
    if (samples_of(session, sensor.clock) >= 1) continue;
    warnings.push_back(
        fmt::format("navigation.{}: there is no sample between the first ping and the last one; "
                    "give a higher rate_hz or a smaller time_offset_s",
                    sensor.name));
  }
  bool locks = !navigation->dvl, echoes = !navigation->altimeter, surfaces = !navigation->gps;
  for (const std::uint32_t ping : distinct_pings(session)) {
    const double time_s = session.ping_times_s[ping];
    const Pose body = pose_at(session.path, time_s);
    const Tracer scene = tracer.at(object_poses(session, ping));
    locks = locks || dvl_has_lock(*navigation->dvl, scene, body);
    echoes = echoes || altimeter_has_echo(*navigation->altimeter, scene, body);
    surfaces = surfaces || compose(body, mount_of(navigation->gps->mount)).position_m.z >=
                               navigation->gps->surface_z_m;
  }
  const char* kWhen = "at the first, the middle and the last ping";
  if (!locks) {
    warnings.push_back(fmt::format(
        "navigation.dvl: no beam meets a surface within range_max_m of {} m {}; give a seabed, a "
        "larger range_max_m, or a mount whose -z axis points down",
        navigation->dvl->range_max_m, kWhen));
  }
  if (!echoes) {
    warnings.push_back(fmt::format(
        "navigation.altimeter: its beam meets no surface within range_max_m of {} m {}; give a "
        "seabed, a larger range_max_m, or a mount whose -z axis points down",
        navigation->altimeter->range_max_m, kWhen));
  }
  if (!surfaces) {
    warnings.push_back(fmt::format(
        "navigation.gps: the antenna is below surface_z_m of {} m {}, and has no fix there",
        navigation->gps->surface_z_m, kWhen));
  }
  return warnings;
}

double navigation_bytes(const Session& session) {
  double bytes = 0;
  if (!session.scenario.navigation) return bytes;
  for (const SensorRows& sensor : sensors_of(*session.scenario.navigation)) {
    bytes += sensor.bytes * samples_of(session, sensor.clock);
  }
  return bytes;
}

}  // namespace ensonify
