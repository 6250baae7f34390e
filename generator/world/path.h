// The way of a body through the world: anything that has a pose at each instant.
//
//   Path        load_path pose_at span_of
//   ping_times  when the pings of a trajectory go out
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "core/error.h"
#include "core/vec.h"
#include "scenario/scenario.h"
#include "world/path_jitter.h"
#include "world/path_ways.h"

namespace ensonify {

struct Path {
  std::variant<SampledWay, LawnmowerWay, OrbitWay, SplineWay> way;
  std::optional<Jitter> jitter;
};

// Errors (usage): those of load_path_file.
Result<Path> load_path(const TrajectorySpec& spec, std::uint64_t jitter_key);

// At the start and the end of its way the body rests, but for the jitter.
Pose pose_at(const Path& path, double time_s);

// Both the same for a path of a single pose.
TimeSpan span_of(const Path& path);

// The path's start + k / rate, as many as asked for, or as the path's length holds (both ends
// included). Errors (usage): more pings than a path other than a single pose lasts for.
Result<std::vector<double>> ping_times(const TrajectorySpec& spec, const Path& path);

}  // namespace ensonify
