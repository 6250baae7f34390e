#include "world/path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/random.h"
#include "scenario/scenario.h"

namespace ensonify {

SampledPath make_path(const std::vector<TimedPoseSpec>& poses) {
  SampledPath path;
  for (const TimedPoseSpec& point : poses) {
    path.points.push_back({point.time_s, pose_of(point.pose)});
  }
  return path;
}

Pose pose_at(const SampledPath& path, double time_s) {
  const auto after =
      std::upper_bound(path.points.begin(), path.points.end(), time_s,
                       [](double t, const PathPoint& point) { return t < point.time_s; });
  if (after == path.points.begin()) return path.points.front().pose;
  const PathPoint& a = *(after - 1);
  if (after == path.points.end() || a.time_s == time_s) return a.pose;
  const double u = (time_s - a.time_s) / (after->time_s - a.time_s);
  return {a.pose.position_m + u * (after->pose.position_m - a.pose.position_m),
          slerp(a.pose.rotation, after->pose.rotation, u)};
}

Pose pose_at(const CarriedPath& path, double time_s) {
  return compose(pose_at(*path.carrier, time_s), path.pose);
}

TimeSpan span_of(const CarriedPath& path) { return span_of(*path.carrier); }

TimeSpan span_of(const SampledPath& path) {
  return {path.points.front().time_s, path.points.back().time_s};
}

namespace {

void move_in_time(SampledPath& path, double by_s) {
  for (PathPoint& point : path.points) point.time_s += by_s;
}
void move_in_time(CarriedPath&, double) {}
template <class Formula>
void move_in_time(Formula& path, double by_s) {
  path.start_time_s += by_s;
}

}  // namespace

std::string path_warning(const Path& path) {
  const auto* sampled = std::get_if<SampledPath>(&path.nominal);
  return sampled != nullptr ? sampled->warning : "";
}

Result<Path> load_path(const TrajectorySpec& spec, std::uint64_t wave_key,
                       std::optional<double> start_s) {
  Path path;
  if (const auto* file = std::get_if<PathFileSpec>(&spec.path)) {
    Result<SampledPath> sampled = load_path_file(file->file);
    if (!sampled) return sampled.error();
    path.nominal = std::move(*sampled);
  } else if (const auto* lawnmower = std::get_if<LawnmowerSpec>(&spec.path)) {
    path.nominal = *lawnmower;
  } else if (const auto* orbit = std::get_if<OrbitSpec>(&spec.path)) {
    path.nominal = *orbit;
  } else if (const auto* spline = std::get_if<SplineSpec>(&spec.path)) {
    path.nominal = make_path(*spline);
  } else {
    path.nominal = make_path(std::get<std::vector<TimedPoseSpec>>(spec.path));
  }
  if (start_s) {
    const double by_s = *start_s - span_of(path).start_s;
    std::visit([&](auto& nominal) { move_in_time(nominal, by_s); }, path.nominal);
  }
  if (spec.wave_motion) {
    path.wave_motion = make_wave_motion(*spec.wave_motion, wave_key, span_of(path).start_s);
  }
  return path;
}

Pose pose_at(const Path& path, double time_s) {
  const Pose pose =
      std::visit([&](const auto& nominal) { return pose_at(nominal, time_s); }, path.nominal);
  return path.wave_motion ? moved_by_waves(*path.wave_motion, time_s, pose) : pose;
}

TimeSpan span_of(const Path& path) {
  return std::visit([](const auto& nominal) { return span_of(nominal); }, path.nominal);
}

namespace {

// Part of a period that rounding may add or take.
constexpr double kPeriodRounding = 1e-9;

// The number of pings that a path lasts after an offset, both ends included.
double pings_within(const TimeSpan& span, double offset_s, double rate_hz) {
  // The last ping must not be lost by the rounding of two time stamps (1e-7 s for Unix times).
  const double rounding_s = 4 * std::numeric_limits<double>::epsilon() *
                            std::max(std::abs(span.start_s), std::abs(span.end_s));
  const double left_s = span.end_s - span.start_s - offset_s + rounding_s;
  return std::floor(left_s * rate_hz + kPeriodRounding) + 1;
}

bool is_dropped(const FrameDrops& drops, std::uint64_t frame) {
  return frame > 0 && drops.share > 0 && uniform(drops.key, 0, frame, 0) < drops.share;
}

bool rests(const Path& path) {
  const auto* sampled = std::get_if<SampledPath>(&path.nominal);
  return sampled != nullptr && sampled->points.size() == 1;
}

Error too_many(double duration_s, double rate_hz, double pings) {
  return {ErrorKind::usage,
          fmt::format("trajectory: {} s at {} pings/s are {} pings; expected at most {}",
                      duration_s, rate_hz, pings, kMaxPings)};
}

}  // namespace

Result<std::vector<double>> ping_times(const TrajectorySpec& spec, const Path& path,
                                       const FrameDrops& drops) {
  const TimeSpan span = span_of(path);
  const double duration = span.end_s - span.start_s;
  const double fitting = pings_within(span, 0, spec.ping_rate_hz);
  if (!spec.pings && fitting > kMaxPings) return too_many(duration, spec.ping_rate_hz, fitting);
  const auto wanted = static_cast<std::size_t>(spec.pings ? *spec.pings : fitting);
  const bool endless = rests(path) && spec.pings.has_value();
  std::vector<double> times;
  for (std::uint64_t k = 0; times.size() < wanted; ++k) {
    if (!endless && static_cast<double>(k) >= fitting) break;
    if (is_dropped(drops, k)) continue;
    times.push_back(span.start_s + static_cast<double>(k) / spec.ping_rate_hz);
  }
  if (spec.pings && times.size() < wanted) {
    return Error{ErrorKind::usage,
                 fmt::format("trajectory.pings: the path lasts {} s, which is {} pings at {} "
                             "pings/s{}, fewer than the requested {}",
                             duration, times.size(), spec.ping_rate_hz,
                             drops.share > 0 ? " without dropped frames" : "", wanted)};
  }
  return times;
}

Result<std::vector<double>> ping_times(const TrajectorySpec& spec, const Path& path,
                                       const PingClock& clock, const FrameDrops& drops) {
  if (const auto common = ping_times(spec, path); !common) return common.error();
  const TimeSpan span = span_of(path);
  double count = HUGE_VAL;
  if (!rests(path) || !spec.pings) count = pings_within(span, clock.offset_s, clock.rate_hz);
  if (spec.pings) {
    const double run_s = *spec.pings / spec.ping_rate_hz;
    const double periods = (run_s - clock.offset_s) * clock.rate_hz;
    count = std::min(count, std::ceil(periods - kPeriodRounding));
  }
  if (count > kMaxPings) return too_many(span.end_s - span.start_s, clock.rate_hz, count);
  std::vector<double> times;
  for (std::uint64_t k = 0; static_cast<double>(k) < count; ++k) {
    if (is_dropped(drops, k)) continue;
    times.push_back(span.start_s + clock.offset_s + static_cast<double>(k) / clock.rate_hz);
  }
  return times;
}

}  // namespace ensonify
