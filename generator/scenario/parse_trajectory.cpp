#include <fmt/format.h>

#include "scenario/parse.h"

namespace ensonify {
namespace {

// The first pose's time does not matter, but with several each needs its own.
void parse_poses(Faults& faults, const Value& list, std::vector<TimedPoseSpec>& poses) {
  if (!open_list(faults, list)) return;
  const std::size_t count = list.node->items.size();
  if (count == 0) {
    add_fault(faults, list.place, list.path, "empty, accepted is a list of at least one pose");
    return;
  }
  poses.assign(count, {});
  std::optional<double> last_time;
  for (std::size_t i = 0; i < count; ++i) {
    const Value map = item(list, i);
    if (!open_map(faults, map, {"time_s", "position_m", "rotation_deg", "quaternion_wxyz"})) {
      continue;
    }
    parse_pose(faults, map, poses[i].pose);
    const Need need = count > 1 ? Need::required : Need::optional;
    if (!read_number(faults, map, "time_s", from_to(-1e12, 1e12), poses[i].time_s, need)) continue;
    if (last_time && poses[i].time_s <= *last_time) {
      const Value time = *child(map, "time_s");
      add_fault(faults, time.place, time.path,
                fmt::format("{} s does not come after the {} s before it, accepted are times that "
                            "increase from pose to pose",
                            poses[i].time_s, *last_time));
    }
    last_time = poses[i].time_s;
  }
}

}  // namespace

void parse_trajectory(const InputFolder& input, const Value& value, TrajectorySpec& trajectory) {
  Faults& faults = input.faults;
  std::vector<TimedPoseSpec> poses(1);
  trajectory.path = poses;
  if (!open_map(faults, value, {"poses", "file", "ping_rate_hz", "pings"})) return;
  if (child(value, "poses") || child(value, "file")) {
    const auto key = only_key_of(faults, value, {"poses", "file"}, "poses or file");
    PathFileSpec path;
    if (key == "poses") {
      parse_poses(faults, *child(value, "poses"), poses);
      trajectory.path = poses;
    } else if (key == "file") {
      parse_input_file(input, value, "file", {".tum", ".txt", ".csv"}, path.file);
      trajectory.path = path;
    }
  }
  read_number(faults, value, "ping_rate_hz", above_up_to(0, 1e6), trajectory.ping_rate_hz);
  const auto* given = std::get_if<std::vector<TimedPoseSpec>>(&trajectory.path);
  trajectory.pings.reset();
  if (given && given->size() == 1) trajectory.pings = 1;
  int pings = 1;
  if (read_integer(faults, value, "pings", 1, kMaxPings, pings)) trajectory.pings = pings;
}

}  // namespace ensonify
