#include "scenario/draw.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/random.h"
#include "scenario/distribution.h"
#include "scenario/key_facts.h"
#include "scenario/keyed_numbers.h"
#include "scenario/sections.h"
#include "scenario/text.h"
#include "scenario/value_text.h"

namespace ensonify {
namespace {

const std::string* name_of_entry(const Node& entry) {
  if (entry.kind != NodeKind::map) return nullptr;
  const Node* name = find(entry, "name");
  return name != nullptr && name->kind == NodeKind::scalar ? &name->text : nullptr;
}

// Paths are expensive to build, so they are skipped for nodes that cannot hold a distribution.
bool has_parts(const Node& node) {
  return node.kind == NodeKind::map || node.kind == NodeKind::list;
}

class Drawer {
 public:
  // With `extreme`, numbers take their extremes instead of random values.
  Drawer(std::uint64_t key, const DrawExtreme* extreme, UseReport& report,
         std::vector<DrawnValue>& draws)
      : numbers_{key, extreme},
        report_(report),
        faults_(report.faults),
        wrong_(report.wrong),
        draws_(draws) {
    if (extreme != nullptr) variant_ = extreme->variant;
  }

  void draw(Node& node, const Way& way) {
    if (is_distribution(node)) {
      draw_distribution(node, way);
    } else if (node.kind == NodeKind::map) {
      for (std::size_t i = 0; i < node.items.size(); ++i) {
        if (!has_parts(node.items[i])) continue;
        const std::string& key = node.keys[i].text;
        const Way inner = step(way, key);
        if (may_be_drawn(node.items[i], inner, key)) draw(node.items[i], inner);
      }
    } else if (node.kind == NodeKind::list) {
      draw_list(node, way);
    }
  }

  // The head of a scenario and the names key all other random numbers.
  bool may_be_drawn(const Node& node, const Way& way, std::string_view key) {
    if ((!is_head_key(way.path) && key != "name") || !is_distribution(node)) return true;
    refuse(
        node, way.path,
        "cannot be sampled, because the other random values depend on it; expected a plain value");
    leave_wrong(node);
    return false;
  }

  // Takes the values of `variables`; each may use those before it.
  void draw_variables(Node& variables) {
    const Way all = step({}, kVariables);
    for (std::size_t i = 0; i < variables.items.size(); ++i) {
      const Key& name = variables.keys[i];
      const Way way = step(all, name.text);
      if (!is_variable_name(faults_, name, way.path)) continue;
      const std::size_t found = faults_.found(), wrong = wrong_.size();
      put_values(variables.items[i], "", way.path, table_, report_);
      draw(variables.items[i], way);
      const bool is_well = faults_.found() == found && wrong_.size() == wrong;
      table_[name.text] = is_well ? std::optional(std::move(variables.items[i])) : std::nullopt;
    }
  }

  void put_variables(Node& root) { put_values(root, "", "", table_, report_); }

  // The variables that integer keys use, by their paths.
  void set_whole_variables(std::set<std::string> whole) { whole_variables_ = std::move(whole); }

 private:
  // Readers report errors at the map or at its key.
  void leave_wrong(const Node& node) {
    wrong_.push_back(node.place);
    wrong_.push_back(node.keys[0].place);
  }

  void refuse(const Node& node, const std::string& path, std::string text) {
    add_fault(faults_, node.place, path, std::move(text));
  }

  // File names differ between copies of a scenario, and the keys of a preset may lie under a map.
  // For these the number of the alternative is recorded, which is stable.
  void record(std::size_t at, const Way& way, const Node& node, std::size_t index = 0) {
    const bool nested = has_parts(node);
    const std::size_t dot = way.named.rfind('.');
    const bool file =
        names_file(std::string_view(way.named).substr(dot == std::string::npos ? 0 : dot + 1));
    DrawnValue value{way.named, flow_text(node)};
    if (nested || file) value = {way.named + ".choice", std::to_string(index)};
    // A value that an alternative samples itself replaces this record of the same path.
    const auto from = draws_.begin() + static_cast<std::ptrdiff_t>(at);
    draws_.erase(std::remove_if(from, draws_.end(),
                                [&](const DrawnValue& drawn) { return drawn.path == value.path; }),
                 draws_.end());
    draws_.insert(draws_.begin() + static_cast<std::ptrdiff_t>(at), std::move(value));
  }

  void draw_distribution(Node& node, const Way& way) {
    const bool drawn =
        node.keys[0].text == "choice" ? draw_choice(node, way) : draw_number(node, way);
    if (!drawn) leave_wrong(node);
  }

  // The index of the alternative; empty if there is none.
  std::optional<std::size_t> pick(const Node& node, const Way& way) {
    const std::size_t count = node.items[0].items.size();
    if (count == 0) {
      refuse(node.items[0], step(way, "choice").path,
             "the list is empty; expected at least one alternative");
      return std::nullopt;
    }
    if (numbers_.extreme != nullptr) return pick_variant(node.items[0]);
    const auto index =
        static_cast<std::size_t>(numbers_.uniform_of(way) * static_cast<double>(count));
    return std::min(index, count - 1);
  }

  // Afterwards variant_ is that of the alternative, until its caller is done.
  std::size_t pick_variant(const Node& alternatives) {
    variant_ %= variants_of_choice(alternatives);
    std::size_t index = 0;
    for (std::size_t has; variant_ >= (has = draw_variants(alternatives.items[index])); ++index) {
      variant_ -= has;
    }
    return index;
  }

  bool draw_choice(Node& node, const Way& way) {
    const std::size_t variant = variant_;
    const auto index = pick(node, way);
    if (!index) return false;
    const std::size_t at = draws_.size();
    Node chosen = std::move(node.items[0].items[*index]);
    draw(chosen, alternative(way, *index));
    variant_ = variant;
    node = std::move(chosen);
    record(at, way, node, *index);
    return true;
  }

  bool draw_number(Node& node, const Way& way) {
    const std::string kind = node.keys[0].text;
    Node& list = node.items[0];
    const Way list_way = step(way, kind);
    for (std::size_t i = 0; i < list.items.size(); ++i) {
      draw(list.items[i], step(list_way, std::to_string(i)));
    }
    std::array<double, 2> given{};
    const Value map{&node, node.place, way.path};
    if (!read_numbers(faults_, map, kind, from_to(-1e300, 1e300), given)) return false;
    const std::string trouble = distribution_trouble(kind, given);
    if (!trouble.empty()) {
      refuse(list, list_way.path, trouble);
      return false;
    }
    Node value;
    value.kind = NodeKind::scalar;
    value.place = node.place;
    value.text = kind == "uniform" ? uniform_text(list, given, way)
                                   : number(numbers_.drawn(kind, given, way));
    node = std::move(value);
    record(draws_.size(), way, node);
    return true;
  }

  // Integers between integer limits, both included.
  std::string uniform_text(const Node& list, const std::array<double, 2>& given, const Way& way) {
    const std::string path = without_choices(way.path);
    if (!reads_whole_numbers(path) && !whole_variables_.contains(path))
      return number(numbers_.drawn("uniform", given, way));
    const auto low = whole_number(list.items[0]);
    const auto high = whole_number(list.items[1]);
    if (!low || !high) return number(numbers_.drawn("uniform", given, way));
    const double span = static_cast<double>(*high - *low) + 1;
    const auto above = static_cast<std::int64_t>(numbers_.uniform_of(way) * span);
    return std::to_string(std::min(*low + above, *high));
  }

  void draw_list(Node& list, const Way& way) {
    std::vector<Node> entries;
    for (std::size_t i = 0; i < list.items.size(); ++i) {
      if (has_parts(list.items[i])) {
        draw_entry(std::move(list.items[i]), way, step(way, std::to_string(i)), entries);
      } else {
        entries.push_back(std::move(list.items[i]));
      }
    }
    list.items = std::move(entries);
    if (way.named == "objects") name_parents(list, object_copies_, faults_);
  }

  // One entry of a list; `unnamed` is its path if it has no name.
  void draw_entry(Node entry, const Way& list, const Way& unnamed, std::vector<Node>& out) {
    if (is_distribution(entry) && entry.keys[0].text == "choice") {
      return draw_entry_of_choice(std::move(entry), list, unnamed, out);
    }
    const std::string* name = name_of_entry(entry);
    Way way = unnamed;
    if (name != nullptr) {
      way = step(list, "", *name);
      way.path = unnamed.path;
    }
    const bool counted = is_counted_list(list.named) && entry.kind == NodeKind::map &&
                         find(entry, "count") != nullptr;
    if (counted && name != nullptr) return expand(std::move(entry), *name, list, way, out);
    draw(entry, way);
    out.push_back(std::move(entry));
  }

  void draw_entry_of_choice(Node entry, const Way& list, const Way& unnamed,
                            std::vector<Node>& out) {
    const std::size_t at = draws_.size();
    const std::size_t first = out.size();
    const std::size_t variant = variant_;
    const auto index = pick(entry, unnamed);
    if (!index) {
      leave_wrong(entry);
      out.push_back(std::move(entry));
      return;
    }
    draw_entry(std::move(entry.items[0].items[*index]), list, alternative(unnamed, *index), out);
    variant_ = variant;
    // An alternative that is not a single scalar is recorded by its number.
    const bool single = out.size() == first + 1;
    record(at, unnamed, single ? out.back() : entry, *index);
  }

  // An entry with a count becomes name_0, name_1, ..., each sampled separately.
  void expand(Node entry, const std::string& name, const Way& list, const Way& way,
              std::vector<Node>& out) {
    Node* count_node = find(entry, "count");
    draw(*count_node, step(way, "count"));
    int count = 0;
    const Value map{&entry, entry.place, way.path};
    // A wrong distribution has been reported already.
    if (!is_distribution(*count_node)) read_integer(faults_, map, "count", 0, kMaxCount, count);
    const auto at = count_node - entry.items.data();
    const Place place = count_node->place;
    entry.items.erase(entry.items.begin() + at);
    entry.keys.erase(entry.keys.begin() + at);
    const std::string stem = name;
    copies_ += values_in(entry) * static_cast<std::size_t>(count);
    if (copies_ > faults_.limits.values) {
      add_fault(faults_, place, step(way, "count").path,
                fmt::format("the counts stand for more than {} values; expected fewer",
                            faults_.limits.values));
      return;
    }
    if (list.named == "objects") object_copies_.push_back({stem, count, out.size()});
    const std::size_t before = faults_.found();
    bool is_wrong = false;  // the other copies would repeat the same errors
    for (int k = 0; k < count; ++k) {
      Node copy = is_wrong ? out.back() : entry;
      Node& own_name = *find(copy, "name");
      own_name.text = fmt::format("{}_{}", stem, k);
      Way own = step(list, "", own_name.text);
      own.path = way.path;
      if (!is_wrong) put_index(copy, k, own.path);
      if (!is_wrong) draw(copy, own);
      is_wrong = faults_.found() != before;
      out.push_back(std::move(copy));
    }
  }

  void put_index(Node& copy, int k, const std::string& path) {
    if (!uses_variables(copy)) return;
    Node index;
    index.kind = NodeKind::scalar;
    index.text = std::to_string(k);
    table_[std::string(kIndex)] = std::move(index);
    put_values(copy, "", path, table_, report_);
    table_.erase(std::string(kIndex));
  }

  KeyedNumbers numbers_;
  std::size_t variant_ = 0;  // of the node that is being sampled
  UseReport& report_;
  Faults& faults_;
  std::vector<Place>& wrong_;
  std::vector<DrawnValue>& draws_;
  std::size_t copies_ = 0;  // how many values they hold
  std::vector<Copies> object_copies_;
  VariableTable table_;
  std::set<std::string> whole_variables_;
};

// Removes `variables` from the tree and puts their values where they are used.
void settle_variables(Node& root, Drawer& drawer, Faults& faults) {
  Node* variables = find(root, kVariables);
  if (variables != nullptr) {
    if (variables->kind == NodeKind::map && !is_distribution(*variables)) {
      drawer.set_whole_variables(whole_variables(root));
      drawer.draw_variables(*variables);
    } else if (variables->kind != NodeKind::null) {
      add_fault(faults, variables->place, kVariables,
                "not a map; expected a map of names, such as {depth_m: {uniform: [3, 8]}}");
    }
    const auto at = variables - root.items.data();
    root.items.erase(root.items.begin() + at);
    root.keys.erase(root.keys.begin() + at);
  }
  drawer.put_variables(root);
}

void draw_tree(Node& root, Drawer& drawer, Faults& faults) {
  settle_variables(root, drawer, faults);
  for (std::size_t i = 0; i < root.items.size(); ++i) {
    const Way way = step({}, root.keys[i].text);
    if (drawer.may_be_drawn(root.items[i], way, root.keys[i].text)) {
      drawer.draw(root.items[i], way);
    }
  }
}

}  // namespace

void draw_values(Node& root, std::uint64_t seed, SequenceDraw draw, Faults& faults,
                 std::vector<Place>& wrong, std::vector<VariableUse>& uses,
                 std::vector<DrawnValue>& draws) {
  UseReport report{faults, wrong, uses};
  Drawer drawer(stream_key(seed, Stream::world, draw), nullptr, report, draws);
  draw_tree(root, drawer, faults);
  std::sort(draws.begin(), draws.end(),
            [](const DrawnValue& a, const DrawnValue& b) { return a.path < b.path; });
}

void draw_extremes(Node& root, const DrawExtreme& extreme, Faults& faults,
                   std::vector<Place>& wrong, std::vector<VariableUse>& uses) {
  std::vector<DrawnValue> draws;
  UseReport report{faults, wrong, uses};
  Drawer drawer(0, &extreme, report, draws);
  draw_tree(root, drawer, faults);
}

}  // namespace ensonify
