#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/random.h"
#include "scenario/key_facts.h"
#include "scenario/text.h"
#include "sweep/axes.h"

namespace ensonify {
namespace {

using Words = std::vector<std::string_view>;

const Words kSources = {"values", "linear", "log", "uniform", "log_uniform"};
constexpr std::string_view kSourcesInWords =
    "one of values (a list), linear, log, uniform or log_uniform ([a, b], with count)";

// Whether `faults` has grown while an axis was read.
class Watch {
 public:
  explicit Watch(const Faults& faults) : faults_(faults), before_(faults.found()) {}
  bool quiet() const { return faults_.found() == before_; }

 private:
  const Faults& faults_;
  std::size_t before_;
};

std::string last_part(const std::string& key) { return key.substr(key.rfind('.') + 1); }

// The number that represents a value in conditions.
double number_of(const Node& node, std::size_t index) {
  const std::string json = node.kind == NodeKind::scalar ? json_of_node(node) : "";
  if (json == "true" || json == "false") return json == "true";
  if (json.empty() || json.front() == '"') return static_cast<double>(index);
  // Unlike stod it accepts numbers that are too small to be normal.
  return std::strtod(json.c_str(), nullptr);
}

std::string cut(std::string text) {
  if (text.size() <= kMaxNameBytes) return text;
  std::size_t end = kMaxNameBytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end);
}

class AxisParser {
 public:
  AxisParser(Faults& faults, std::uint64_t seed) : faults_(faults), seed_(seed) {}

  std::optional<AxisGroup> group(const Value& value) {
    if (value.node->kind == NodeKind::map && find(*value.node, "zip") != nullptr) {
      return zip(value);
    }
    AxisGroup group;
    std::optional<Axis> one = axis(value);
    if (!one) return std::nullopt;
    group.axes.push_back(std::move(*one));
    return group;
  }

 private:
  std::optional<AxisGroup> zip(const Value& value) {
    const Watch watch(faults_);
    open_map(faults_, value, {"zip"});
    const Value list = *child(value, "zip");
    if (!open_list(faults_, list)) return std::nullopt;
    AxisGroup group;
    for (std::size_t i = 0; i < list.node->items.size(); ++i) {
      if (auto one = axis(item(list, i))) group.axes.push_back(std::move(*one));
    }
    if (watch.quiet() && group.axes.size() < 2) {
      add_fault(faults_, list.place, list.path,
                "the zip has fewer than two axes; expected two or more");
    }
    for (const Axis& one : group.axes) {
      if (one.values.size() == group.axes[0].values.size()) continue;
      add_fault(faults_, one.place, list.path,
                fmt::format("{} has {} values, but {} has {}; expected axes of equal length",
                            shown(one.name), one.values.size(), shown(group.axes[0].name),
                            group.axes[0].values.size()));
    }
    return watch.quiet() ? std::optional(std::move(group)) : std::nullopt;
  }

  std::optional<Axis> axis(const Value& value) {
    const Watch watch(faults_);
    if (!open_map(faults_, value,
                  {"key", "name", "values", "labels", "linear", "log", "uniform", "log_uniform",
                   "count", "zip"})) {
      return std::nullopt;
    }
    if (const auto inner = child(value, "zip")) {
      add_fault(faults_, inner->place, inner->path, "a zip inside a zip; expected plain axes");
      return std::nullopt;
    }
    Axis made;
    made.place = value.place;
    std::string key;
    read_text(faults_, value, "key", key, Need::optional, kMaxFileNameBytes);
    read_name(value, key, made.name);
    // The missing key may be the one that was mistyped.
    if (!watch.quiet() && !has_any(value, kSources)) return std::nullopt;
    const auto source = only_key_of(faults_, value, kSources, kSourcesInWords);
    if (!source) return std::nullopt;
    if (const auto given = child(value, "key")) key_place_ = given->place;
    if (*source == "values") {
      refuse_useless(faults_, value, {"count"}, "with values, which are counted from the list");
      read_values(value, key, made);
    } else {
      refuse_useless(faults_, value, {"labels"}, "without values");
      if (!child(value, "key")) {
        add_fault(
            faults_, value.place, path_of(value, "key"),
            fmt::format("missing next to {}; expected the key path that the numbers are set at",
                        *source));
      }
      read_range(value, *source, key, made);
    }
    return watch.quiet() ? std::optional(std::move(made)) : std::nullopt;
  }

  static bool has_any(const Value& value, const Words& keys) {
    return std::any_of(keys.begin(), keys.end(),
                       [&](std::string_view key) { return child(value, key).has_value(); });
  }

  void read_name(const Value& value, const std::string& key, std::string& name) {
    const auto given = child(value, "name");
    if (given) {
      if (!read_text(faults_, value, "name", name)) return;
    } else if (child(value, "key")) {
      name = last_part(key);
    } else {
      add_fault(faults_, value.place, path_of(value, "name"),
                "missing; expected a name for an axis without a key");
      return;
    }
    const Place at = given ? given->place : value.place;
    if (name == "seed" && key != "seed") {
      add_fault(faults_, at, path_of(value, "name"),
                "seed is the name of the seed of a run; expected another name");
    } else if (!name.empty() && !is_axis_name(name)) {
      add_fault(
          faults_, at, path_of(value, "name"),
          fmt::format(
              "{} is not a name for an axis; expected a letter followed by letters, digits and _{}",
              shown(name), given ? "" : ", given by `name`"));
    }
  }

  void read_values(const Value& value, const std::string& key, Axis& axis) {
    const Value list = *child(value, "values");
    if (!open_list(faults_, list)) return;
    if (!check_count(list, list.node->items.size())) return;
    const bool has_key = child(value, "key").has_value();
    for (std::size_t i = 0; i < list.node->items.size(); ++i) {
      const Value given = item(list, i);
      AxisValue made;
      if (has_key) {
        made.settings.push_back({key, key_place_, *given.node});
        made.label = cut(plain_text(*given.node));
        made.json = json_of_node(*given.node);
        made.number = number_of(*given.node, i);
      } else {
        read_map(given, made);
        made.label = made.json = std::to_string(i);
        made.number = static_cast<double>(i);
      }
      axis.values.push_back(std::move(made));
    }
    read_labels(value, axis);
  }

  // {KEY.PATH: value, ...}
  void read_map(const Value& given, AxisValue& made) {
    if (given.node->kind != NodeKind::map) {
      add_fault(faults_, given.place, given.path,
                "not a map; expected a map of key paths and their values, or a `key` of the axis "
                "for its values");
      return;
    }
    for (std::size_t k = 0; k < given.node->keys.size(); ++k) {
      const Key& key = given.node->keys[k];
      made.settings.push_back({key.text, key.place, given.node->items[k]});
    }
  }

  void read_labels(const Value& value, Axis& axis) {
    const auto list = child(value, "labels");
    if (!list || !open_list(faults_, *list)) return;
    if (list->node->items.size() != axis.values.size()) {
      add_fault(faults_, list->place, list->path,
                fmt::format("found {} labels for {} values; expected one label for each value",
                            list->node->items.size(), axis.values.size()));
      return;
    }
    std::map<std::string, std::size_t> seen;
    for (std::size_t i = 0; i < axis.values.size(); ++i) {
      const Value given = item(*list, i);
      const Key as_key{given.node->text, given.node->quoted, given.place};
      if (given.node->kind != NodeKind::scalar) {
        add_fault(faults_, given.place, given.path, "not a label; expected a word");
      } else if (is_name(faults_, as_key, given.path)) {
        if (!seen.emplace(given.node->text, i).second) {
          add_fault(
              faults_, given.place, given.path,
              fmt::format("{} is given twice; expected different labels", shown(given.node->text)));
        }
        Node text = *given.node;
        text.quoted = true;
        axis.values[i].label = text.text;
        axis.values[i].json = json_of_node(text);
      }
    }
  }

  bool check_count(const Value& list, std::size_t count) {
    if (count > 0 && count <= kMaxAxisValues) return true;
    add_fault(
        faults_, list.place, list.path,
        fmt::format("found a list of length {}; expected 1 to {} values", count, kMaxAxisValues));
    return false;
  }

  void read_range(const Value& value, std::string_view kind, const std::string& key, Axis& axis) {
    std::array<double, 2> ends{};
    int count = 0;
    const bool counted =
        read_integer(faults_, value, "count", 1, kMaxAxisValues, count, Need::required);
    if (!read_numbers(faults_, value, kind, from_to(-1e300, 1e300), ends)) return;
    const Value list = *child(value, kind);
    const auto [a, b] = ends;
    const bool logarithmic = kind == "log" || kind == "log_uniform";
    if (logarithmic && (a <= 0 || b <= 0)) {
      add_fault(
          faults_, list.place, list.path,
          fmt::format(
              "the limits {} and {} do not both have a logarithm; expected two numbers above zero",
              a, b));
    } else if ((kind == "uniform" || kind == "log_uniform") && a > b) {
      add_fault(faults_, list.place, list.path,
                fmt::format("{} is above {}; expected [a, b] with a <= b", a, b));
    } else if (counted) {
      fill_range(list, kind, key, ends, count, axis);
    }
  }

  void fill_range(const Value& list, std::string_view kind, const std::string& key,
                  const std::array<double, 2>& ends, int count, Axis& axis) {
    counted_ += static_cast<std::size_t>(count);
    if (counted_ > faults_.limits.counted_values) {
      add_fault(
          faults_, list.place, list.path,
          fmt::format(
              "with this one the counts of all axes produce more than {} values; expected fewer",
              faults_.limits.counted_values));
      return;
    }
    const auto [a, b] = ends;
    const bool whole = reads_whole_numbers(key);
    const bool between_whole = whole && std::floor(a) == a && std::floor(b) == b;
    const std::uint64_t random = mix64(stream_key(seed_, Stream::sweep, 0) ^ name_key(axis.name));
    std::vector<double> values = kind == "linear" ? linear_values(a, b, count)
                                 : kind == "log"  ? log_values(a, b, count)
                                 : kind == "uniform"
                                     ? uniform_values(a, b, count, random, between_whole)
                                     : log_uniform_values(a, b, count, random);
    for (double number : values) {
      if (whole) number = std::round(number);
      Node node;
      node.kind = NodeKind::scalar;
      node.place = list.place;
      node.text = fmt::format("{}", number);
      AxisValue value{node.text, json_of_node(node), number, {}};
      value.settings.push_back({key, key_place_, std::move(node)});
      axis.values.push_back(std::move(value));
    }
  }

  Faults& faults_;
  std::uint64_t seed_;
  Place key_place_;          // of the axis that is being read
  std::size_t counted_ = 0;  // values that counts produced so far
};

void check_shared(Faults& faults, const std::string& list_path,
                  const std::vector<AxisGroup>& groups) {
  std::map<std::string, const Axis*> names, paths;
  for (const AxisGroup& group : groups) {
    for (const Axis& axis : group.axes) {
      if (!names.emplace(axis.name, &axis).second) {
        add_fault(
            faults, axis.place, list_path,
            fmt::format("two axes have the name {}; expected different names, given by `name`",
                        shown(axis.name)));
      }
      for (const AxisValue& value : axis.values) {
        for (const Setting& setting : value.settings) {
          const auto [other, fresh] = paths.emplace(setting.path, &axis);
          if (fresh || other->second == &axis) continue;
          add_fault(faults, setting.place, list_path,
                    fmt::format("{} already belongs to the axis {}; expected one axis per key",
                                shown(setting.path), shown(other->second->name)));
        }
      }
    }
  }
}

}  // namespace

bool is_axis_name(std::string_view name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !name.empty() && name.size() <= kMaxNameBytes && letter(name[0]) &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

std::vector<AxisGroup> parse_axes(Faults& faults, const Value& list, std::uint64_t seed) {
  std::vector<AxisGroup> groups;
  if (!open_list(faults, list)) return groups;
  AxisParser parser(faults, seed);
  for (std::size_t i = 0; i < list.node->items.size(); ++i) {
    if (auto group = parser.group(item(list, i))) groups.push_back(std::move(*group));
  }
  check_shared(faults, list.path, groups);
  return groups;
}

}  // namespace ensonify
