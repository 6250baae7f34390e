// The built-in materials.
//
//   known_materials  lay_known_materials
#pragma once

#include <string>
#include <vector>

#include "scenario/yaml_tree.h"

namespace ensonify {

// The materials of configs/materials.yaml, and a tree in which those that it names and does not define
// stand under `materials`, and each `preset` of a material is replaced by its keys. Done before
// sampling, and after it for presets that are sampled themselves.
std::vector<std::string> known_materials();
void lay_known_materials(Node& root);

}  // namespace ensonify
