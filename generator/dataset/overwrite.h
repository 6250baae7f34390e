// Finds the files of ensonify in a folder, so that --overwrite removes only these. Private to
// dataset/.
//
// A file is ours if a manifest lists it: dataset.json, a sequence.json or, for work interrupted
// before those were written, a plan in .work, which lists files before they are written.
//
//   plan_sequence  plan_top_level
//   take_inventory  remove_listed
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/ping.h"

namespace ensonify {

// Writes the sequence's plan if it has none yet. `templates` name the files of a ping (layout.h).
Status plan_sequence(const std::filesystem::path& dir, const SequenceInfo& info,
                     const std::vector<std::string>& templates);

// Writes the plan of the finishing step.
Status plan_top_level(const std::filesystem::path& dir, const std::vector<std::string>& files);

struct Inventory {
  std::vector<std::string> listed;     // our existing files, in a safe order of removal
  std::vector<std::string> strangers;  // in no manifest
};

// Searches a folder that has a valid work.json or dataset.json; changes nothing. Error (usage): a
// manifest names a path outside the folder, or a foreign file has a name that a data set could use.
// Error (io): the folder cannot be read.
Result<Inventory> take_inventory(const std::filesystem::path& dir);

// Removes the listed files except work.json, then .work and empty folders. The old work.json stays
// until a new one replaces it, so that an interrupted removal can resume. Error (io): a file cannot
// be removed.
Status remove_listed(const std::filesystem::path& dir, const Inventory& inventory);

}  // namespace ensonify
