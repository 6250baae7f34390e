// Whether a disk has room for the files of a run.
//
//   folder_there  free_bytes   for the disk of a folder, existing or not
//   disk_bytes                 size of a whole data set, from measured pings
//   room_for_bytes             the error of a disk without room
//   room_for_work              before `generate` writes
//   room_for_runs              before `sweep` writes
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "run/make_dataset.h"
#include "run/measure.h"
#include "run/options.h"
#include "sweep/expand.h"

namespace ensonify {

// The folder, or its nearest existing parent.
std::filesystem::path folder_there(const std::filesystem::path& folder);

// Absent if the system does not report it.
std::optional<std::uint64_t> free_bytes(const std::filesystem::path& folder);

// The final size of all files of a scenario, from measured pings.
double disk_bytes(const Measured& measured, const Session& session);

// Error (io): fewer than `needed` bytes are free. No error if `free` is absent.
Status room_for_bytes(const std::filesystem::path& folder, double needed,
                      const std::optional<std::uint64_t>& free);

// By an estimate from the table of outputs, which for most scenes is within 20 %. Existing files of
// the same work need no room. `needed` is what other instruments of a rig need, and what this one
// needs is added. Error: that of room_for_bytes.
Status room_for_work(const GenerateOptions& options, const SequenceWorlds& worlds,
                     const DatasetWork& work, double& needed);

// The same for runs, given by their numbers in the sweep: from the estimates of their cost.
Status room_for_runs(const SweepOptions& options, const Sweep& sweep,
                     const std::vector<std::size_t>& runs);

}  // namespace ensonify
