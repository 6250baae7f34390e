// Whether a disk has room for the files of a run.
//
//   folder_there  free_bytes   for the disk of a folder, existing or not
//   Remaining  all_of  disk_bytes   size of the missing files, from measured pings
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

// The missing parts of a data set.
struct Remaining {
  std::uint64_t pings = 0;             // to be made
  std::uint64_t sequences = 0;         // to be finished
  std::uint64_t sequence_pings = 0;    // ... all pings of these
  std::uint64_t listed_sequences = 0;  // in the top level; 0: another process writes it
  std::uint64_t listed_pings = 0;
};

// All of a data set that has nothing yet.
Remaining all_of(const MeasureJob& job);

// The final size of all files together.
double disk_bytes(const Measured& measured, const Session& session, const Remaining& remaining);

// Error (io): fewer than `needed` bytes are free. No error if `free` is absent.
Status room_for_bytes(const std::filesystem::path& folder, double needed,
                      const std::optional<std::uint64_t>& free);

// Existing files of the same work need no room. A few pings are measured only if an estimate is
// close to the free space; parts of the first world that are computed for that are added to
// `first`. Errors: those of room_for_bytes and measure_pings.
Status room_for_work(const GenerateOptions& options, const SequenceWorlds& worlds,
                     const DatasetWork& work, const Numerics& numerics, int threads,
                     SharedParts& first);

// The same for runs, given by their numbers in the sweep: from the estimates of their cost, which
// are scaled by the measured size of the first run if they are close to the free space. Error: that
// of room_for_bytes.
Status room_for_runs(const SweepOptions& options, const Sweep& sweep,
                     const std::vector<std::size_t>& runs, const Numerics& numerics, int threads);

}  // namespace ensonify
