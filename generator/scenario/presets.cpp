#include <charconv>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>

#include "core/error.h"
#include "scenario/merge.h"
#include "scenario/preset_files.h"
#include "scenario/scenario.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

// The comment lines at the head of the file, without their # signs.
std::string head_comment(std::string_view text) {
  std::string comment;
  while (text.starts_with('#')) {
    const std::size_t newline = text.find('\n');
    std::string_view line =
        text.substr(1, newline == std::string_view::npos ? newline : newline - 1);
    if (line.starts_with(' ')) line.remove_prefix(1);
    if (!comment.empty()) comment += '\n';
    comment += line;
    if (newline == std::string_view::npos) break;
    text.remove_prefix(newline + 1);
  }
  return comment;
}

constexpr std::string_view kRows = "by_range_max_m";
constexpr std::string_view kLimit = "up_to_m";

// Each preset is parsed when it is first named: all of them take longer than most scenarios.
const Node& tree_of_preset(std::size_t index) {
  struct Parsed {
    std::once_flag once;
    Node tree;
  };
  static const auto parsed = std::make_unique<Parsed[]>(sonar_presets().size());
  Parsed& entry = parsed[index];
  std::call_once(entry.once, [&] {
    const SonarPreset& preset = sonar_presets()[index];
    Faults faults;
    auto tree = read_yaml_map(preset.yaml, add_source(faults, preset.name), faults);
    ENSONIFY_ASSERT(tree && faults.empty());
    entry.tree = std::move(*tree);
  });
  return entry.tree;
}

// The first row whose limit is at least range_m, or the last row.
const Node& row_for(const Node& rows, double range_m) {
  for (const Node& row : rows.items) {
    if (range_m <= number_in(row, kLimit).value_or(0)) return row;
  }
  return rows.items.back();
}

}  // namespace

std::optional<double> number_in(const Node& map, std::string_view key) {
  const Node* node = map.kind == NodeKind::map ? find(map, key) : nullptr;
  if (node == nullptr || node->kind != NodeKind::scalar || node->quoted) return std::nullopt;
  std::string_view text = node->text;
  if (text.starts_with('+')) text.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

const std::vector<SonarPreset>& sonar_presets() {
  static const std::vector<SonarPreset> presets = [] {
    std::vector<SonarPreset> made;
    for (const PresetFile& file : preset_files()) {
      made.push_back({file.name, head_comment(file.text), file.text});
    }
    return made;
  }();
  return presets;
}

bool preset_depends_on_range(std::size_t index) {
  return find(tree_of_preset(index), kRows) != nullptr;
}

Node preset_tree(std::size_t index, const Node& sonar) {
  const Node& preset = tree_of_preset(index);
  const Node* rows = find(preset, kRows);
  if (rows == nullptr) return preset;
  ENSONIFY_ASSERT(rows->kind == NodeKind::list && !rows->items.empty());
  const auto own_range_m = number_in(preset, "range_max_m");
  ENSONIFY_ASSERT(own_range_m);
  const double range_m = number_in(sonar, "range_max_m").value_or(*own_range_m);
  return merge_over(without(preset, kRows), without(row_for(*rows, range_m), kLimit));
}

}  // namespace ensonify
