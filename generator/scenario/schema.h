// The schema of scenarios, generated from the fields of their sections, and its key paths.
#pragma once

#include <string>
#include <vector>

namespace ensonify {

// output_schema/scenario.schema.json: JSON Schema, draft 7, for editors and validators. It accepts
// every valid scenario; rules that need the whole scenario are checked only by the program. In
// addition to the standard it has "unit" and "left_out" (what a missing key stands for), for the
// key reference.
std::string scenario_schema();

// Paths of keys with a single value that --set can reach without an index or a name.
std::vector<std::string> key_paths();

}  // namespace ensonify
