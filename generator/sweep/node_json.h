// A value of a sweep as JSON and as a word of a name. Private to sweep/.
//
//   json_of_node   on one line
//   plain_text     a scalar as it is written, anything else as JSON
#pragma once

#include <string>

#include "scenario/yaml_tree.h"

namespace ensonify {

std::string json_of_node(const Node& node);
std::string plain_text(const Node& node);

}  // namespace ensonify
