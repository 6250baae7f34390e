#include <fmt/format.h>

#include "scenario/emit.h"

namespace ensonify {

std::string trajectory_text(const TrajectorySpec& trajectory, const NameFile& name_file) {
  std::string text = "trajectory:\n";
  if (const auto* path = std::get_if<PathFileSpec>(&trajectory.path)) {
    text += fmt::format("  file: {}\n", quoted_if_needed(name_file(path->file)));
  } else {
    text += "  poses:\n";
    for (const TimedPoseSpec& pose : std::get<std::vector<TimedPoseSpec>>(trajectory.path)) {
      text += fmt::format("    - {{time_s: {}, {}}}\n", number(pose.time_s), pose_keys(pose.pose));
    }
  }
  text += fmt::format("  ping_rate_hz: {}\n", number(trajectory.ping_rate_hz));
  if (trajectory.pings) text += fmt::format("  pings: {}\n", *trajectory.pings);
  return text;
}

}  // namespace ensonify
