#include "world/path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <utility>

#include "core/counted.h"
#include "core/random.h"
#include "scenario/scenario.h"
#include "scenario/text.h"

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

Result<Path> load_path(const TrajectorySpec& spec, std::uint64_t wave_key) {
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

Result<std::vector<double>> ping_times(const TrajectorySpec& spec, const Path& path,
                                       const FrameDrops& drops) {
  const TimeSpan span = span_of(path);
  const double duration = span.end_s - span.start_s;
  // The last ping must not be lost by the rounding of two time stamps (1e-7 s for Unix times).
  const double rounding_s = 4 * std::numeric_limits<double>::epsilon() *
                            std::max(std::abs(span.start_s), std::abs(span.end_s));
  const double fitting = std::floor((duration + rounding_s) * spec.ping_rate_hz + 1e-9) + 1;
  if (!spec.pings && fitting > kMaxPings) {
    return Error{ErrorKind::usage,
                 fmt::format("trajectory: {} s at {} pings/s are {} pings; expected at most {}",
                             duration, spec.ping_rate_hz, fitting, kMaxPings)};
  }
  const auto wanted = static_cast<std::size_t>(spec.pings ? *spec.pings : fitting);
  const auto* sampled = std::get_if<SampledPath>(&path.nominal);
  const bool rests = sampled && sampled->points.size() == 1;
  const bool endless = rests && spec.pings.has_value();
  std::vector<double> times;
  for (std::uint64_t k = 0; times.size() < wanted; ++k) {
    if (!endless && static_cast<double>(k) >= fitting) break;
    if (k > 0 && drops.share > 0 && uniform(drops.key, 0, k, 0) < drops.share) continue;
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

namespace {

namespace fs = std::filesystem;

Error at_line(const fs::path& file, std::size_t line, const std::string& why) {
  return {ErrorKind::usage, fmt::format("{}:{}: {}", file.string(), line, why)};
}

// The words of a line: cells of a CSV, or words between blanks.
std::vector<std::string> words_of(const std::string& text, bool csv) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; csv ? bool(std::getline(stream, word, ',')) : bool(stream >> word);) {
    const auto is_blank = [](unsigned char c) { return std::isspace(c) != 0; };
    word.erase(word.begin(), std::find_if_not(word.begin(), word.end(), is_blank));
    while (!word.empty() && is_blank(static_cast<unsigned char>(word.back()))) word.pop_back();
    words.push_back(word);
  }
  return words;
}

Result<std::vector<double>> numbers_of(const std::string& text, bool csv, const fs::path& file,
                                       std::size_t line) {
  std::vector<double> numbers;
  for (const std::string& word : words_of(text, csv)) {
    std::size_t used = 0;
    double value = 0;
    try {
      value = std::stod(word, &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (word.empty() || used != word.size() || !std::isfinite(value)) {
      return at_line(file, line, fmt::format("'{}' is not a finite number", word));
    }
    numbers.push_back(value);
  }
  return numbers;
}

// Columns of time_s x y z qw qx qy qz in a line.
using Columns = std::array<std::size_t, 8>;
constexpr std::array<const char*, 8> kColumnNames{"time_s", "x", "y", "z", "qw", "qx", "qy", "qz"};
constexpr Columns kTumColumns{0, 1, 2, 3, 7, 4, 5, 6};

Result<Columns> columns_of_header(const std::string& header, const fs::path& file,
                                  std::size_t line) {
  std::map<std::string, std::size_t> place;
  const std::vector<std::string> names = words_of(header, true);
  for (std::size_t i = 0; i < names.size(); ++i) place[names[i]] = i;
  Columns columns{};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto found = place.find(kColumnNames[i]);
    if (found == place.end()) {
      return at_line(file, line,
                     fmt::format("the header has no column {}; expected time_s, x, y, z, qw, "
                                 "qx, qy, qz",
                                 kColumnNames[i]));
    }
    columns[i] = found->second;
  }
  return columns;
}

Result<PathPoint> point_of(const std::vector<double>& v, const Columns& columns,
                           const fs::path& file, std::size_t line) {
  const std::size_t wanted = *std::max_element(columns.begin(), columns.end()) + 1;
  if (v.size() < wanted) {
    return at_line(file, line,
                   fmt::format("found {}; expected {}", counted(v.size(), "number"), wanted));
  }
  const auto at = [&](int i) { return v[columns[i]]; };
  const Quat q{at(4), at(5), at(6), at(7)};
  const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  // Files round to four digits; a larger error means that it is not a rotation.
  if (!(std::abs(norm - 1) < 0.01)) {
    return at_line(file, line, fmt::format("the quaternion has length {}; expected 1", norm));
  }
  return PathPoint{at(0), {{at(1), at(2), at(3)}, normalized(q)}};
}

}  // namespace

Result<SampledPath> load_path_file(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream) {
    return Error{ErrorKind::usage, fmt::format("{}: cannot be read", file.string())};
  }
  const bool csv = equals_ignoring_case(file.extension().string(), ".csv");
  std::optional<Columns> columns;
  if (!csv) columns = kTumColumns;
  SampledPath path;
  std::string text;
  for (std::size_t line = 1; std::getline(stream, text); ++line) {
    if (line == 1 && text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // a byte order mark
    if (const auto start = text.find_first_not_of(" \t\r");
        start == std::string::npos || text[start] == '#') {
      continue;
    }
    if (!columns) {
      Result<Columns> header = columns_of_header(text, file, line);
      if (!header) return header.error();
      columns = *header;
      continue;
    }
    const Result<std::vector<double>> numbers = numbers_of(text, csv, file, line);
    if (!numbers) return numbers.error();
    const Result<PathPoint> point = point_of(*numbers, *columns, file, line);
    if (!point) return point.error();
    if (!path.points.empty() && !(point->time_s > path.points.back().time_s)) {
      return at_line(file, line,
                     fmt::format("time {} is not after {}; expected rising times", point->time_s,
                                 path.points.back().time_s));
    }
    path.points.push_back(*point);
  }
  if (path.points.empty()) {
    return Error{ErrorKind::usage, fmt::format("{}: holds no poses", file.string())};
  }
  return path;
}

}  // namespace ensonify
