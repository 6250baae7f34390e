#include <algorithm>

#include <fmt/format.h>

#include "scenario/parse.h"
#include "scenario/parse_ways.h"
#include "scenario/text.h"

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
    if (!read_number(faults, map, "time_s", kPathTime, poses[i].time_s, need)) continue;
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

const std::vector<std::string_view> kWays = {"poses", "file", "lawnmower", "orbit", "spline"};

void parse_way(const InputFolder& input, const Value& value, TrajectorySpec& trajectory) {
  Faults& faults = input.faults;
  trajectory.path = std::vector<TimedPoseSpec>(1);
  const auto key = only_key_of(faults, value, kWays, "one of " + joined(kWays));
  if (!key) return;
  const Value way = *child(value, *key);
  if (*key == "poses") {
    parse_poses(faults, way, std::get<std::vector<TimedPoseSpec>>(trajectory.path));
  } else if (*key == "file") {
    parse_input_file(input, value, "file", {".tum", ".txt", ".csv"},
                     trajectory.path.emplace<PathFileSpec>().file);
  } else if (*key == "lawnmower") {
    parse_lawnmower(faults, way, trajectory.path.emplace<LawnmowerSpec>());
  } else if (*key == "orbit") {
    parse_orbit(faults, way, trajectory.path.emplace<OrbitSpec>());
  } else {
    parse_spline(faults, way, trajectory.path.emplace<SplineSpec>());
  }
}

void parse_jitter_of(Faults& faults, const Value& value, TrajectorySpec& trajectory) {
  if (const auto jitter = child(value, "jitter")) {
    parse_jitter(faults, *jitter, trajectory.jitter.emplace());
  }
}

}  // namespace

void parse_trajectory(const InputFolder& input, const Value& value, TrajectorySpec& trajectory) {
  Faults& faults = input.faults;
  trajectory.path = std::vector<TimedPoseSpec>(1);
  std::vector<std::string_view> known = kWays;
  known.insert(known.end(), {"jitter", "ping_rate_hz", "pings"});
  if (!open_map(faults, value, known)) return;
  // The sonar may rest at the origin; an object with a trajectory has a way to go.
  const bool any = std::any_of(kWays.begin(), kWays.end(),
                               [&](std::string_view way) { return child(value, way).has_value(); });
  if (any) parse_way(input, value, trajectory);
  parse_jitter_of(faults, value, trajectory);
  read_number(faults, value, "ping_rate_hz", above_up_to(0, 1e6), trajectory.ping_rate_hz);
  const auto* given = std::get_if<std::vector<TimedPoseSpec>>(&trajectory.path);
  trajectory.pings.reset();
  if (given && given->size() == 1) trajectory.pings = 1;
  int pings = 1;
  if (read_integer(faults, value, "pings", 1, kMaxPings, pings)) trajectory.pings = pings;
}

void parse_object_trajectory(const InputFolder& input, const Value& value,
                             TrajectorySpec& trajectory) {
  std::vector<std::string_view> known = kWays;
  known.push_back("jitter");
  if (value.node->kind == NodeKind::map) {
    for (const std::string_view key : {"ping_rate_hz", "pings"}) {
      if (child(value, key)) known.push_back(key);
    }
    refuse_useless(input.faults, value, {"ping_rate_hz", "pings"},
                   "on an object, accepted in the sonar's own trajectory");
  }
  if (!open_map(input.faults, value, known)) return;
  parse_way(input, value, trajectory);
  parse_jitter_of(input.faults, value, trajectory);
}

}  // namespace ensonify
