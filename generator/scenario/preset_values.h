// Values of a sonar preset that follow from one that the scenario has changed. Private to
// scenario/.
//
//   PresetKeys  follow_preset
#pragma once

#include <string>

#include "scenario/scenario.h"
#include "scenario/yaml_tree.h"

namespace ensonify {

inline constexpr int kMaxRays = 1'000'000;

// The keys of a preset, and those that the scenario gives next to it.
struct PresetKeys {
  std::string name;
  Node preset;
  const Node* given = nullptr;
};

// Sets fan and rays of a sonar whose pattern in elevation is not that of the preset, unless the
// scenario gives them, and adds a notice about another frequency. Needs a sonar that was read
// without errors.
void follow_preset(const PresetKeys& keys, SonarSpec& sonar);

}  // namespace ensonify
