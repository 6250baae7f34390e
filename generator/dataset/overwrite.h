// What in a folder is ensonify's, so that --overwrite removes that and nothing else. Private to
// dataset/.
//
// A file is ours if a manifest lists it: dataset.json, a sequence.json, or, for work that was cut
// off before those were written, a plan in .work, which says beforehand what is about to be
// written.
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
  std::vector<std::string> listed;     // ours and there, in an order that is safe to remove them in
  std::vector<std::string> strangers;  // nobody's
};

// Looks through a folder that has a valid work.json or dataset.json; changes nothing.
// Error (usage): a manifest names a path that leaves the folder, or a stranger's file stands where
// a data set could put one of its own. Error (io): the folder cannot be read.
Result<Inventory> take_inventory(const std::filesystem::path& dir);

// Removes what is listed but for work.json, and .work, and the folders that are empty then. The old
// work.json stays until a new one takes its name, so that a removal that was cut off can be taken
// up again. Error (io): a file cannot be removed.
Status remove_listed(const std::filesystem::path& dir, const Inventory& inventory);

}  // namespace ensonify
