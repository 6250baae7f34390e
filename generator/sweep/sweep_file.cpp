#include "sweep/sweep_file.h"

#include <algorithm>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "scenario/scenario.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxConditionBytes = 4096;
constexpr std::size_t kMaxRunNameBytes = 1024;
constexpr int kMaxSeeds = kMaxAxisValues;

std::string default_name(const std::string& label) {
  const std::string stem = fs::path(label).stem().string();
  const bool printable = !first_invalid_utf8(stem) && !first_control_character(stem, "");
  return printable && !stem.empty() && stem.size() <= kMaxNameBytes ? stem : "sweep";
}

// The axis that sets this key path in all of its values.
const Axis* axis_of(const SweepFile& sweep, std::string_view path, bool always) {
  for (const AxisGroup& group : sweep.axes) {
    for (const Axis& axis : group.axes) {
      std::size_t count = 0;
      for (const AxisValue& value : axis.values) {
        for (const Setting& setting : value.settings) count += setting.path == path;
      }
      if (always ? count == axis.values.size() : count > 0) return &axis;
    }
  }
  return nullptr;
}

class SweepParser {
 public:
  SweepParser(const fs::path& folder, Faults& faults) : folder_(folder), faults_(faults) {}

  SweepFile parse(const Value& root, const std::string& label,
                  const std::vector<Override>& overrides) {
    const auto scenario = child(root, "ensonify");
    if (scenario && !child(root, "ensonify_sweep")) {
      add_fault(faults_, scenario->place, scenario->path,
                "this is a scenario; expected a sweep (`ensonify generate` reads scenarios)");
      return sweep_;
    }
    open_map(
        faults_, root,
        {"ensonify_sweep", "name", "base", "set", "axes", "seed", "seeds", "run_name", "skip_if"});
    int version = 0;
    read_integer(faults_, root, "ensonify_sweep", 1, 1, version, Need::required);
    sweep_.name = default_name(label);
    read_text(faults_, root, "name", sweep_.name);
    std::uint64_t seed = 0;
    read_seed(faults_, root, "seed", seed);
    const std::size_t before = faults_.found();
    if (const auto axes = child(root, "axes")) sweep_.axes = parse_axes(faults_, *axes, seed);
    axes_are_whole_ = faults_.found() == before;
    read_base(root);
    if (const auto set = child(root, "set")) put_in(*set);
    put_in(overrides);
    if (sweep_.tree) {
      Faults told_later;
      read_seed(told_later, {&*sweep_.tree, {}, ""}, "seed", sweep_.base_seed);
    }
    if (const auto seeds = child(root, "seeds")) read_seeds(*seeds, root);
    read_run_name(root);
    if (const auto skip = child(root, "skip_if")) read_conditions(*skip);
    count_points(root);
    return std::move(sweep_);
  }

 private:
  void read_base(const Value& root) {
    std::string base;
    if (!read_text(faults_, root, "base", base, Need::required, kMaxFileNameBytes)) return;
    sweep_.base = (folder_ / base).lexically_normal();
    const std::string label = sweep_.base.string();
    faults_.sources[1] = label;
    const Result<std::string> text = read_scenario_text(sweep_.base);
    if (!text) {
      const Value given = *child(root, "base");
      return add_fault(faults_, given.place, given.path, text.error().message);
    }
    auto tree = read_yaml_map(*text, 1, faults_);
    if (tree) sweep_.tree = std::make_shared<const Node>(std::move(*tree));
  }

  void put_in(const Value& set) {
    if (set.node->kind != NodeKind::map) {
      add_fault(
          faults_, set.place, set.path,
          "not a map; expected a map of key paths and their values, such as {trajectory.pings: 3}");
      return;
    }
    if (!sweep_.tree) return;
    Node tree = *sweep_.tree;
    for (std::size_t i = 0; i < set.node->keys.size(); ++i) {
      const Key& key = set.node->keys[i];
      refuse_axis(key.text, key.place, path_of(set, key.text));
      apply_setting(tree, {key.text, key.place, set.node->items[i]}, faults_);
    }
    sweep_.tree = std::make_shared<const Node>(std::move(tree));
  }

  void put_in(const std::vector<Override>& overrides) {
    if (!sweep_.tree || overrides.empty()) return;
    Node tree = *sweep_.tree;
    for (const Override& given : overrides) {
      refuse_axis(given.path, {add_source(faults_, "--set " + given.path), 0, 0}, given.path);
    }
    apply_overrides(tree, overrides, faults_);
    sweep_.tree = std::make_shared<const Node>(std::move(tree));
  }

  void refuse_axis(std::string_view key, const Place& place, const std::string& path) {
    const Axis* axis = axis_of(sweep_, key, true);
    if (axis == nullptr) return;
    add_fault(faults_, place, path,
              fmt::format("has no effect with the axis {}", shown(axis->name)));
  }

  void read_seeds(const Value& seeds, const Value& root) {
    sweep_.seeds_place = seeds.place;
    if (const Axis* axis = axis_of(sweep_, "seed", false)) {
      add_fault(
          faults_, seeds.place, seeds.path,
          fmt::format(
              "cannot be given with the axis {}, which sets the seed; expected only one of them",
              shown(axis->name)));
    }
    if (seeds.node->kind == NodeKind::list) return read_seed_list(seeds);
    int count = 0;
    if (!read_integer(faults_, root, "seeds", 1, kMaxSeeds, count)) return;
    if (sweep_.base_seed > std::numeric_limits<std::uint64_t>::max() - kMaxSeeds) {
      add_fault(faults_, seeds.place, seeds.path,
                fmt::format("the seed {} of the base has no {} after it; expected a list of seeds",
                            sweep_.base_seed, count));
      return;
    }
    for (int i = 0; i < count; ++i) {
      sweep_.seeds.push_back(sweep_.base_seed + static_cast<std::uint64_t>(i));
    }
  }

  void read_seed_list(const Value& seeds) {
    const std::size_t count = seeds.node->items.size();
    if (count == 0 || count > kMaxSeeds) {
      add_fault(faults_, seeds.place, seeds.path,
                fmt::format("found a list of length {}; expected 1 to {} seeds", count, kMaxSeeds));
      return;
    }
    std::set<std::uint64_t> seen;
    for (std::size_t i = 0; i < count; ++i) {
      // As a key of a map, for read_seed.
      Node map;
      map.kind = NodeKind::map;
      map.keys.push_back({std::to_string(i), false, seeds.place});
      map.items.push_back(seeds.node->items[i]);
      std::uint64_t seed = 0;
      if (!read_seed(faults_, {&map, seeds.place, seeds.path}, map.keys[0].text, seed)) continue;
      if (!seen.insert(seed).second) {
        add_fault(faults_, map.items[0].place, path_of(seeds, map.keys[0].text),
                  fmt::format("{} is given twice; expected different seeds", seed));
      }
      sweep_.seeds.push_back(seed);
    }
  }

  void read_run_name(const Value& root) {
    std::string text;
    if (!read_text(faults_, root, "run_name", text, Need::optional, kMaxRunNameBytes)) return;
    const Value given = *child(root, "run_name");
    const std::vector<std::string> names = variable_names(sweep_);
    const std::vector<std::string_view> known(names.begin(), names.end());
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t open = text.find_first_of("{}", at);
      if (open > at) sweep_.run_name.push_back({text.substr(at, open - at)});
      if (open == std::string::npos) return;
      const std::size_t close = text.find_first_of("{}", open + 1);
      if (text[open] == '}' || close == std::string::npos || text[close] == '{') {
        add_fault(faults_, given.place, given.path,
                  "the braces do not match; expected text with axes such as {" + names[0] + "}");
        return;
      }
      const std::string name = text.substr(open + 1, close - open - 1);
      if (axes_are_whole_ && std::find(names.begin(), names.end(), name) == names.end()) {
        add_fault(faults_, given.place, given.path,
                  fmt::format("{} is not an axis{}; expected one of {}", shown(name),
                              hint(name, known), joined(known)));
      }
      sweep_.run_name.push_back({name, true});
      at = close + 1;
    }
  }

  void read_conditions(const Value& skip) {
    if (!open_list(faults_, skip)) return;
    Conditions conditions(variable_names(sweep_));
    for (std::size_t i = 0; i < skip.node->items.size(); ++i) {
      const Value given = item(skip, i);
      if (given.node->kind != NodeKind::scalar || given.node->text.empty() ||
          given.node->text.size() > kMaxConditionBytes ||
          first_control_character(given.node->text, "")) {
        add_fault(faults_, given.place, given.path,
                  fmt::format("not a condition; expected one line of up to {} bytes, such as "
                              "\"range_max_m > 10 && frequency_hz < 5e5\"",
                              kMaxConditionBytes));
        continue;
      }
      const auto trouble = axes_are_whole_ ? conditions.add(given.node->text) : std::nullopt;
      if (trouble) add_fault(faults_, given.place, given.path, *trouble);
      sweep_.skip_if.push_back({given.node->text, given.place, given.path});
    }
  }

  void count_points(const Value& root) {
    if (!child(root, "axes") && !child(root, "seeds")) {
      add_fault(faults_, root.place, "axes", "missing; expected axes or seeds");
    }
    if (const auto axes = child(root, "axes");
        axes && axes->node->kind == NodeKind::list && axes->node->items.empty()) {
      add_fault(faults_, axes->place, axes->path, "the list is empty; expected at least one axis");
    }
    sweep_.product = std::max<std::size_t>(1, sweep_.seeds.size());
    for (const AxisGroup& group : sweep_.axes) {
      sweep_.product *= group.axes[0].values.size();
      if (sweep_.product <= kMaxAxisValues) continue;
      const Value axes = child_or_empty(root, "axes");
      add_fault(faults_, axes.place, axes.path,
                fmt::format("there are more than {} points with all seeds; expected fewer",
                            kMaxAxisValues));
      return;
    }
  }

  const fs::path& folder_;
  Faults& faults_;
  SweepFile sweep_;
  bool axes_are_whole_ = false;  // otherwise a text that names an unknown axis may be right
};

}  // namespace

Result<SweepFile> parse_sweep_file(const std::string& text, const std::string& label,
                                   const fs::path& folder, const ReadLimits& limits,
                                   const std::vector<Override>& overrides) {
  Faults faults;
  faults.limits = limits;
  add_source(faults, label);
  add_source(faults, "");  // the base, once its name is known
  const auto tree = read_yaml_map(text, 0, faults);
  if (!tree) return to_error(faults);
  SweepFile sweep = SweepParser(folder, faults).parse({&*tree, tree->place, ""}, label, overrides);
  if (!faults.empty()) return to_error(faults);
  sweep.sources = faults.sources;
  return sweep;
}

Result<SweepFile> load_sweep_file(const fs::path& file, const std::vector<Override>& overrides) {
  const Result<std::string> text = read_scenario_text(file, "a sweep");
  if (!text) return text.error();
  return parse_sweep_file(*text, file.string(), file.parent_path(), {}, overrides);
}

}  // namespace ensonify
