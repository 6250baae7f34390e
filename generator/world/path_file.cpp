// Paths from files: TUM, and CSV with the names of a data set's poses.csv or of EuRoC.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

#include "core/counted.h"
#include "core/keys.h"
#include "core/units.h"
#include "scenario/text.h"
#include "world/path.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

Error at_line(const fs::path& file, std::size_t line, const std::string& why) {
  return {ErrorKind::usage, fmt::format("{}:{}: {}", file.string(), line, why)};
}

void trim(std::string& word) {
  const auto is_blank = [](unsigned char c) { return std::isspace(c) != 0; };
  word.erase(word.begin(), std::find_if_not(word.begin(), word.end(), is_blank));
  while (!word.empty() && is_blank(static_cast<unsigned char>(word.back()))) word.pop_back();
}

// The words of a line: cells of a CSV, which may stand in quotes, or words between blanks.
std::vector<std::string> words_of(const std::string& text, bool csv) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; csv ? bool(std::getline(stream, word, ',')) : bool(stream >> word);) {
    trim(word);
    if (csv && word.size() >= 2 && word.front() == '"' && word.back() == '"') {
      word = word.substr(1, word.size() - 2);
      trim(word);
    }
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

// Where a line has time, x, y, z, qw, qx, qy and qz, and the unit of the time.
struct Columns {
  std::array<std::size_t, 8> at{};
  double time_unit_s = 1;
};
using Names = std::array<const char*, 8>;
constexpr Names kOwnNames{"time_s", "x", "y", "z", "qw", "qx", "qy", "qz"};
constexpr Names kEurocNames{"timestamp", "p_RS_R_x", "p_RS_R_y", "p_RS_R_z",
                            "q_RS_w",    "q_RS_x",   "q_RS_y",   "q_RS_z"};
constexpr Columns kTumColumns{{0, 1, 2, 3, 7, 4, 5, 6}};

// The columns of a header by their names, without the units in brackets that may follow a name.
std::map<std::string, std::size_t> places_in(const std::string& header) {
  std::map<std::string, std::size_t> places;
  const std::vector<std::string> words = words_of(header, true);
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::string name = words[i].substr(0, words[i].find('['));
    trim(name);
    places[name] = i;
  }
  return places;
}

// The missing name, or the columns.
std::pair<const char*, Columns> columns_in(const std::map<std::string, std::size_t>& places,
                                           const Names& names) {
  Columns columns;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = places.find(names[i]);
    if (found == places.end()) return {names[i], {}};
    columns.at[i] = found->second;
  }
  return {nullptr, columns};
}

// EuRoC's header is a comment, and its times are nanoseconds.
std::optional<Columns> euroc_columns(const std::string& text) {
  const std::size_t start = text.find_first_not_of(" \t#");
  if (start == std::string::npos) return std::nullopt;
  auto [missing, columns] = columns_in(places_in(text.substr(start)), kEurocNames);
  if (missing != nullptr) return std::nullopt;
  columns.time_unit_s = 1e-9;
  return columns;
}

Result<Columns> columns_of_header(const std::string& header, const fs::path& file,
                                  std::size_t line) {
  if (const auto euroc = euroc_columns(header)) return *euroc;
  const auto [missing, columns] = columns_in(places_in(header), kOwnNames);
  if (missing == nullptr) return columns;
  return at_line(file, line,
                 fmt::format("the header {} has no column {}; expected time_s, x, y, z, qw, qx, "
                             "qy, qz, or the names of EuRoC (#timestamp, p_RS_R_x, ...)",
                             shown(header), missing));
}

Result<PathPoint> point_of(const std::vector<double>& v, const Columns& columns,
                           const fs::path& file, std::size_t line) {
  const std::size_t wanted = *std::max_element(columns.at.begin(), columns.at.end()) + 1;
  if (v.size() < wanted) {
    return at_line(file, line,
                   fmt::format("found {}; expected {}", counted(v.size(), "number"), wanted));
  }
  const auto at = [&](int i) { return v[columns.at[i]]; };
  for (int i = 1; i <= 3; ++i) {
    if (std::abs(at(i)) <= kMaxLengthM) continue;
    return at_line(file, line,
                   fmt::format("{} is {} m; expected a number from {} to {} m", kOwnNames[i], at(i),
                               -kMaxLengthM, kMaxLengthM));
  }
  const Quat q{at(4), at(5), at(6), at(7)};
  const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  // Files round to four digits; a larger error means that it is not a rotation.
  if (!(std::abs(norm - 1) < 0.01)) {
    return at_line(file, line, fmt::format("the quaternion has length {}; expected 1", norm));
  }
  const double time_s = columns.time_unit_s == 1 ? at(0) : at(0) * columns.time_unit_s;
  return PathPoint{time_s, {{at(1), at(2), at(3)}, normalized(q)}};
}

struct Step {
  double distance_m = 0, turn_rad = 0;
};

Step step_between(const Pose& a, const Pose& b) {
  const Quat turn = conjugate(a.rotation) * b.rotation;
  const double sine = std::sqrt(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z);
  return {length(b.position_m - a.position_m), 2 * std::atan2(sine, std::abs(turn.w))};
}

// A pose at the time of the one before it.
struct Repeated {
  std::size_t after = 0;  // index of the pose with this time that is kept
  PathPoint point;
  std::size_t line = 0;
};

// Differences that measuring and rounding leave between two poses at rest.
constexpr double kSameM = 1e-3, kSameRad = radians(0.1);

// Refuses a repeated pose that is farther from the kept one than its neighbors in time.
Status check_repeated(const SampledPath& path, const std::vector<Repeated>& all,
                      const fs::path& file) {
  for (const Repeated& repeated : all) {
    const PathPoint& kept = path.points[repeated.after];
    Step most{kSameM, kSameRad};
    for (const std::size_t other : {repeated.after - 1, repeated.after + 1}) {
      if (other >= path.points.size()) continue;  // also before the first
      const Step step = step_between(kept.pose, path.points[other].pose);
      most = {std::max(most.distance_m, step.distance_m), std::max(most.turn_rad, step.turn_rad)};
    }
    const Step apart = step_between(kept.pose, repeated.point.pose);
    if (apart.distance_m <= most.distance_m && apart.turn_rad <= most.turn_rad) continue;
    return at_line(file, repeated.line,
                   fmt::format("time {} stands at the pose before, too, but the two are {:.3g} m "
                               "and {:.3g} degrees apart, more than poses at neighboring times; "
                               "expected one pose for each time",
                               kept.time_s, apart.distance_m, degrees(apart.turn_rad)));
  }
  return {};
}

std::string repeated_text(const SampledPath& path, const std::vector<Repeated>& all,
                          const fs::path& file) {
  if (all.empty()) return "";
  double furthest_m = 0;
  for (const Repeated& repeated : all) {
    furthest_m = std::max(
        furthest_m, step_between(path.points[repeated.after].pose, repeated.point.pose).distance_m);
  }
  return fmt::format(
      "{}:{}: time {} is that of the pose before, too; used the first pose of each time (left out: "
      "{}, up to {:.2g} m away from it)",
      file.string(), all.front().line, path.points[all.front().after].time_s,
      counted(all.size(), "pose"), furthest_m);
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
  std::vector<Repeated> repeated;
  std::string text;
  for (std::size_t line = 1; std::getline(stream, text); ++line) {
    if (line == 1 && text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // a byte order mark
    if (const auto start = text.find_first_not_of(" \t\r");
        start == std::string::npos || text[start] == '#') {
      if (!columns && start != std::string::npos) columns = euroc_columns(text);
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
    if (!path.points.empty() && point->time_s == path.points.back().time_s) {
      repeated.push_back({path.points.size() - 1, *point, line});
      continue;
    }
    if (!path.points.empty() && point->time_s < path.points.back().time_s) {
      return at_line(file, line,
                     fmt::format("time {} is not after {}; expected rising times", point->time_s,
                                 path.points.back().time_s));
    }
    path.points.push_back(*point);
  }
  if (path.points.empty()) {
    return Error{ErrorKind::usage, fmt::format("{}: holds no poses", file.string())};
  }
  if (Status same = check_repeated(path, repeated, file); !same) return same.error();
  path.warning = repeated_text(path, repeated, file);
  return path;
}

}  // namespace ensonify
