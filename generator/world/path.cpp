#include "world/path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ensonify {

SampledWay make_way(const std::vector<TimedPoseSpec>& poses) {
  SampledWay way;
  for (const TimedPoseSpec& point : poses) {
    way.points.push_back({point.time_s, pose_of(point.pose)});
  }
  return way;
}

Pose pose_on(const SampledWay& way, double time_s) {
  const auto after =
      std::upper_bound(way.points.begin(), way.points.end(), time_s,
                       [](double t, const PathPoint& point) { return t < point.time_s; });
  if (after == way.points.begin()) return way.points.front().pose;
  const PathPoint& a = *(after - 1);
  if (after == way.points.end() || a.time_s == time_s) return a.pose;
  const double u = (time_s - a.time_s) / (after->time_s - a.time_s);
  return {a.pose.position_m + u * (after->pose.position_m - a.pose.position_m),
          slerp(a.pose.rotation, after->pose.rotation, u)};
}

TimeSpan span_of(const SampledWay& way) {
  return {way.points.front().time_s, way.points.back().time_s};
}

Result<Path> load_path(const TrajectorySpec& spec, std::uint64_t jitter_key) {
  Path path;
  if (const auto* file = std::get_if<PathFileSpec>(&spec.path)) {
    Result<SampledWay> way = load_path_file(file->file);
    if (!way) return way.error();
    path.way = std::move(*way);
  } else if (const auto* lawnmower = std::get_if<LawnmowerSpec>(&spec.path)) {
    path.way = make_way(*lawnmower);
  } else if (const auto* orbit = std::get_if<OrbitSpec>(&spec.path)) {
    path.way = make_way(*orbit);
  } else if (const auto* spline = std::get_if<SplineSpec>(&spec.path)) {
    path.way = make_way(*spline);
  } else {
    path.way = make_way(std::get<std::vector<TimedPoseSpec>>(spec.path));
  }
  if (spec.jitter) path.jitter = make_jitter(*spec.jitter, jitter_key, span_of(path).start_s);
  return path;
}

Pose pose_at(const Path& path, double time_s) {
  const Pose pose = std::visit([&](const auto& way) { return pose_on(way, time_s); }, path.way);
  return path.jitter ? jittered(*path.jitter, time_s, pose) : pose;
}

TimeSpan span_of(const Path& path) {
  return std::visit([](const auto& way) { return span_of(way); }, path.way);
}

Result<std::vector<double>> ping_times(const TrajectorySpec& spec, const Path& path) {
  const TimeSpan span = span_of(path);
  const double duration = span.end_s - span.start_s;
  // The last digits of two stamps (a Unix time has 1e-7 s of them) must not cost the last ping.
  const double rounding_s = 4 * std::numeric_limits<double>::epsilon() *
                            std::max(std::abs(span.start_s), std::abs(span.end_s));
  const double fitting = std::floor((duration + rounding_s) * spec.ping_rate_hz + 1e-9) + 1;
  if (!spec.pings && fitting > kMaxPings) {
    return Error{ErrorKind::usage,
                 fmt::format("trajectory: {} s at {} pings/s are {} pings; at most {}", duration,
                             spec.ping_rate_hz, fitting, kMaxPings)};
  }
  const int pings = spec.pings ? *spec.pings : static_cast<int>(fitting);
  const auto* sampled = std::get_if<SampledWay>(&path.way);
  const bool rests = sampled && sampled->points.size() == 1;
  if (!rests && pings > fitting) {
    return Error{ErrorKind::usage,
                 fmt::format("trajectory.pings: the path lasts {} s, which holds {} pings at {} "
                             "pings/s; {} are asked for",
                             duration, fitting, spec.ping_rate_hz, pings)};
  }
  std::vector<double> times(pings);
  for (int k = 0; k < pings; ++k) times[k] = span.start_s + k / spec.ping_rate_hz;
  return times;
}

}  // namespace ensonify
