#include <fmt/format.h>

#include "scenario/emit.h"

namespace ensonify {
namespace {

using Poses = std::vector<TimedPoseSpec>;

std::string timed_pose(const TimedPoseSpec& pose) {
  return fmt::format("{{time_s: {}, {}}}", number(pose.time_s), pose_keys(pose.pose));
}

std::string way(const Poses& poses, const NameFile&) {
  std::string text;
  for (const TimedPoseSpec& pose : poses) text += (text.empty() ? "" : ", ") + timed_pose(pose);
  return "poses: [" + text + "]";
}

std::string way(const PathFileSpec& path, const NameFile& name_file) {
  return "file: " + quoted_if_needed(name_file(path.file));
}

std::string way(const LawnmowerSpec& way, const NameFile&) {
  return fmt::format(
      "lawnmower: {{corner_m: {}, length_m: {}, width_m: {}, spacing_m: {}, heading_deg: {}, "
      "speed_m_s: {}, start_time_s: {}}}",
      numbers(way.corner_m), number(way.length_m), number(way.width_m), number(way.spacing_m),
      number(way.heading_deg), number(way.speed_m_s), number(way.start_time_s));
}

std::string way(const OrbitSpec& way, const NameFile&) {
  const char* look = way.look == OrbitLook::inward    ? "inward"
                     : way.look == OrbitLook::outward ? "outward"
                                                      : "along";
  return fmt::format(
      "orbit: {{center_m: {}, radius_m: {}, speed_m_s: {}, turns: {}, start_deg: {}, look: {}, "
      "start_time_s: {}}}",
      numbers(way.center_m), number(way.radius_m), number(way.speed_m_s), number(way.turns),
      number(way.start_deg), look, number(way.start_time_s));
}

std::string way(const SplineSpec& way, const NameFile&) {
  std::string points;
  for (const auto& point : way.points_m) points += (points.empty() ? "" : ", ") + numbers(point);
  const std::string look =
      way.look_at_m ? fmt::format("{{at_m: {}}}", numbers(*way.look_at_m)) : "along";
  return fmt::format("spline: {{points_m: [{}], speed_m_s: {}, look: {}, start_time_s: {}}}",
                     points, number(way.speed_m_s), look, number(way.start_time_s));
}

std::string way_text(const TrajectorySpec& trajectory, const NameFile& name_file) {
  return std::visit([&](const auto& path) { return way(path, name_file); }, trajectory.path);
}

std::string jitter_text(const JitterSpec& jitter) {
  return fmt::format(
      "jitter: {{roll_deg: {}, pitch_deg: {}, yaw_deg: {}, heave_m: {}, period_s: {}, "
      "bandwidth: {}}}",
      number(jitter.roll_deg), number(jitter.pitch_deg), number(jitter.yaw_deg),
      number(jitter.heave_m), number(jitter.period_s), number(jitter.bandwidth));
}

}  // namespace

std::string object_trajectory_text(const TrajectorySpec& trajectory, const NameFile& name_file) {
  std::string text = way_text(trajectory, name_file);
  if (trajectory.jitter) text += ", " + jitter_text(*trajectory.jitter);
  return fmt::format("trajectory: {{{}}}", text);
}

std::string trajectory_text(const TrajectorySpec& trajectory, const NameFile& name_file) {
  std::string text = "trajectory:\n";
  if (const auto* poses = std::get_if<Poses>(&trajectory.path)) {
    text += "  poses:\n";
    for (const TimedPoseSpec& pose : *poses) text += fmt::format("    - {}\n", timed_pose(pose));
  } else {
    text += fmt::format("  {}\n", way_text(trajectory, name_file));
  }
  if (trajectory.jitter) text += fmt::format("  {}\n", jitter_text(*trajectory.jitter));
  text += fmt::format("  ping_rate_hz: {}\n", number(trajectory.ping_rate_hz));
  if (trajectory.pings) text += fmt::format("  pings: {}\n", *trajectory.pings);
  return text;
}

}  // namespace ensonify
