// A sweep file as a checked struct, with the base scenario that it varies.
//
//   SweepFile  load_sweep_file  parse_sweep_file
//   Point  points_of            one combination of values; all of a sweep, in order
//   PointValue  values_of  name_of   a point's value of each axis; its name
//   settings_of                 what a point puts into the base
//   variable_names              what conditions and names of runs may use
//   Conditions                  over the values of the axes, read by muparser: made once, asked for
//                               many points
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

// A piece of run_name: text, or the value of an axis (or `seed`).
struct NamePiece {
  std::string text;
  bool is_value = false;  // of what `text` names
};

struct Condition {
  std::string text;
  Place place;
  std::string path;  // in messages
};

struct SweepFile {
  std::string name;                  // absent: the file's, without its ending
  std::filesystem::path base;        // as found from the sweep file's folder
  std::shared_ptr<const Node> tree;  // of the base, with all that is laid over it
  std::uint64_t base_seed = 0;       // of that tree
  std::vector<AxisGroup> axes;       // in order; the last one varies fastest
  std::vector<std::uint64_t> seeds;  // of each point; empty: the base's own
  Place seeds_place;
  std::vector<NamePiece> run_name;   // empty: all axes, as in range_max_m=5,count=64
  std::vector<Condition> skip_if;    // any that holds leaves a point out
  std::vector<std::string> sources;  // labels of the sweep file (0) and the base (1), for Faults
  std::size_t product = 0;           // points, those that are left out too
};

// Errors (usage): all faults of the sweep file and of the base as text at once, one line each,
// `file:line:column: key.path: what is wrong, what is accepted`. A file that cannot be read: io.
// `overrides` are laid over the base, after `set`.
Result<SweepFile> load_sweep_file(const std::filesystem::path& file,
                                  const std::vector<Override>& overrides = {});

// The same from text; `label` stands for the file's name in messages, `folder` is where it stands.
Result<SweepFile> parse_sweep_file(const std::string& text, const std::string& label,
                                   const std::filesystem::path& folder,
                                   const ReadLimits& limits = {},
                                   const std::vector<Override>& overrides = {});

struct Point {
  std::vector<std::size_t> at;  // which value of each group of axes
  std::optional<std::uint64_t> seed;
};

// In order, without those that skip_if leaves out. Errors (usage): a condition that has no value at
// some point; nothing left.
Result<std::vector<Point>> points_of(const SweepFile& sweep);

// The axes in order, then seed.
std::vector<std::string> variable_names(const SweepFile& sweep);

struct PointValue {
  const Axis& axis;
  const AxisValue& value;
};
// Of all axes, in order.
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

  // What is wrong with it; nothing: it was added. Comparisons and &&, ||, !, arithmetic and
  // functions; no assignment, one value.
  std::optional<std::string> add(const std::string& text);

  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  struct Answer {
    std::size_t holds = none;     // index of the first condition that holds
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
