#include <string_view>

#include "core/error.h"
#include "scenario/preset_files.h"
#include "scenario/scenario.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

// The comment lines at the head, without their marks.
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

}  // namespace

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

const std::vector<Node>& preset_trees() {
  static const std::vector<Node> trees = [] {
    std::vector<Node> read;
    for (const SonarPreset& preset : sonar_presets()) {
      Faults faults;
      auto tree = read_yaml_map(preset.yaml, add_source(faults, preset.name), faults);
      ENSONIFY_ASSERT(tree && faults.empty());
      read.push_back(std::move(*tree));
    }
    return read;
  }();
  return trees;
}

}  // namespace ensonify
