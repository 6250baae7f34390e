// Values as YAML text that reads back to the same values.
//
//   number  quoted_if_needed
//   scalar_text  flow_text     of nodes of a tree
#pragma once

#include <string>

#include "scenario/yaml_tree.h"

namespace ensonify {

// The shortest digits that read back to the same number. YAML 1.1 has no exponent without a point,
// so 1e-05 would be text to some readers.
std::string number(double value);

// Leaves the text unquoted only if no reader could interpret it as anything else.
std::string quoted_if_needed(const std::string& text);

// `in_quotes`: as the user wrote it.
std::string scalar_text(const std::string& text, bool in_quotes);

// A tree as YAML on one line.
std::string flow_text(const Node& node);

}  // namespace ensonify
