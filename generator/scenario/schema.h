// The schema of scenarios, generated from the fields of their sections, and key paths of it.
#pragma once

#include <string>
#include <vector>

namespace ensonify {

// output_schema/scenario.schema.json: JSON Schema, draft 7, for editors and validators. It accepts
// everything that the program accepts, and leaves to the program what only a whole scenario shows.
// Beyond the standard, "unit" and "left_out" (what a key that is not given stands for) are there
// for the key reference.
std::string scenario_schema();

// Paths of the keys with a single value that --set can reach without an index or a name.
std::vector<std::string> key_paths();

}  // namespace ensonify
