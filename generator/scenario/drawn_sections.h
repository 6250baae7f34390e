// The sections of a scenario that hold distributions or counts, as they were before drawing:
// what the resolved text keeps, so that it draws the same again. Private to scenario/.
//
//   keep_drawn_sections   from the merged tree, presets laid under, input files resolved
//   drawn_section  section_text  section_files
//   names_file            whether a key's value is an input file
//   flow_text             a tree as YAML on one line
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/emit.h"
#include "scenario/parse.h"

namespace ensonify {

struct DrawnSection {
  std::string key;  // of the top level
  Node tree;        // values of file keys are whole paths
};

struct DrawnSections {
  std::vector<DrawnSection> list;
};

// Null where nothing is drawn or counted. Faults: input files of any alternative that are not
// there.
std::shared_ptr<const DrawnSections> keep_drawn_sections(const Node& root,
                                                         const InputFolder& input);

// The tree of a section; null if it is not drawn.
const Node* drawn_section(const Scenario& scenario, std::string_view key);

std::string section_text(std::string_view key, const Node& tree, const NameFile& name_file);
std::vector<std::filesystem::path> section_files(const Node& tree);

bool names_file(std::string_view key);

// Reads back to the same tree.
std::string flow_text(const Node& node);

}  // namespace ensonify
