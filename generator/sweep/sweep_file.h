// A sweep file as a checked struct, with the base scenario that it varies.
//
//   SweepFile  load_sweep_file  parse_sweep_file
//   Point  points_of            one combination of values; all points of a sweep, in order
//   PointValue  values_of  name_of   the value of a point on each axis; its name
//   settings_of                 the settings of a point in the base
//   variable_names              the names that conditions and run_name may use
//   Conditions                  over the values of the axes: parsed once, evaluated at many points
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"
#include "scenario/faults.h"
#include "sweep/axes.h"

namespace ensonify {

// A piece of run_name: text, or the value of an axis (or of `seed`).
struct NamePiece {
  std::string text;
  bool is_value = false;  // whether `text` names a value
};

struct Condition {
  std::string text;
  Place place;
  std::string path;  // in messages
};

struct SweepFile {
  std::string name;                  // absent: the file's name without its ending
  std::filesystem::path base;        // found relative to the sweep file's folder
  std::shared_ptr<const Node> tree;  // of the base, with everything merged over it
  std::uint64_t base_seed = 0;       // of that tree
  std::vector<AxisGroup> axes;       // in order; the last one varies fastest
  std::vector<std::uint64_t> seeds;  // of each point; empty: that of the base
  Place seeds_place;
  std::vector<NamePiece> run_name;   // empty: all axes, such as range_max_m=5,count=64
  std::vector<Condition> skip_if;    // a point is skipped if any of them is true
  std::vector<std::string> sources;  // labels of the sweep file (0) and the base (1), for Faults
  std::size_t product = 0;           // points, including skipped ones
};

// Errors (usage): all errors of the sweep file and of the text of the base together, one line per
// error, `file:line:column: key.path: what is wrong; expected what would be right`; io: a file
// cannot be read. `overrides` are merged over the base after `set`.
Result<SweepFile> load_sweep_file(const std::filesystem::path& file,
                                  const std::vector<Override>& overrides = {});

// The same for a text; `label` is the file name in messages and `folder` the folder of the file.
Result<SweepFile> parse_sweep_file(const std::string& text, const std::string& label,
                                   const std::filesystem::path& folder,
                                   const ReadLimits& limits = {},
                                   const std::vector<Override>& overrides = {});

struct Point {
  std::vector<std::size_t> at;  // the index of the value in each group of axes
  std::optional<std::uint64_t> seed;
};

// In order, without those that skip_if skips. Errors (usage): a condition without a value at some
// point; no point is left.
Result<std::vector<Point>> points_of(const SweepFile& sweep);

// The axes in order, then seed.
std::vector<std::string> variable_names(const SweepFile& sweep);

struct PointValue {
  const Axis& axis;
  const AxisValue& value;
};
// The names of all axes, in order.
std::vector<PointValue> values_of(const SweepFile& sweep, const Point& point);
std::string name_of(const SweepFile& sweep, const Point& point);
std::vector<Setting> settings_of(const SweepFile& sweep, const Point& point);

class Conditions {
 public:
  // The variables.
  explicit Conditions(std::vector<std::string> names);
  ~Conditions();
  Conditions(const Conditions&) = delete;
  Conditions& operator=(const Conditions&) = delete;

  // Returns what is wrong with the condition; if empty, it was added. Comparisons, &&, ||, !,
  // arithmetic and functions are valid; assignments and several values are not.
  std::optional<std::string> add(const std::string& text);

  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  struct Answer {
    std::size_t holds = none;     // index of the first condition that is true
    std::size_t no_value = none;  // of the first, if it comes before, that divides by zero, has a
                                  // root of what is below zero, or is not finite
  };
  // Values of the variables, in their order.
  Answer at(std::span<const double> values);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ensonify
