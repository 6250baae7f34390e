// Sections with distributions, counts or uses of variables keep their text in the resolved
// scenario, as `variables` does, so that it samples the same values again.
//
//   keep_drawn_sections   from the tree merged with presets, with resolved input files
//   drawn_section         of a key
//   NameFile  section_text   as text, with the input files named anew
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/field_reader.h"
#include "scenario/scenario.h"
#include "scenario/yaml_tree.h"

namespace ensonify {

struct DrawnSection {
  std::string key;  // of the top level
  Node tree;        // values of file keys are complete paths
};

struct DrawnSections {
  std::vector<DrawnSection> list;
};

// Null if nothing is sampled or counted. Error: an input file of any alternative does not exist.
std::shared_ptr<const DrawnSections> keep_drawn_sections(const Node& root,
                                                         const InputFolder& input);

// The tree of a section; null if the section is not sampled.
const Node* drawn_section(const Scenario& scenario, std::string_view key);

// How an input file is named in the text.
using NameFile = std::function<std::string(const std::filesystem::path&)>;

std::string section_text(std::string_view key, const Node& tree, const NameFile& name_file);

}  // namespace ensonify
