// Whether a disk has room for what is to be written.
//
//   folder_there  free_bytes   of the disk that a folder is on, or will be
//   Remaining  disk_bytes      what is still to be written, from measured pings
//   room_for_bytes             the error of a disk that has no room
//   room_for_work              before `generate` writes
//   room_for_runs              before `sweep` writes
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "app/commands.h"
#include "app/make_dataset.h"
#include "app/measure.h"
#include "sweep/expand.h"

namespace ensonify {

// The folder, or where it will be.
std::filesystem::path folder_there(const std::filesystem::path& folder);

// Absent where the system does not say.
std::optional<std::uint64_t> free_bytes(const std::filesystem::path& folder);

// What of a data set is not there yet.
struct Remaining {
  std::uint64_t pings = 0;             // to be made
  std::uint64_t sequences = 0;         // to be finished
  std::uint64_t sequence_pings = 0;    // ... all pings of these
  std::uint64_t listed_sequences = 0;  // on the top level; 0: another process writes that
  std::uint64_t listed_pings = 0;
};

// Of all files together, in the end.
double disk_bytes(const Measured& measured, const Session& session, const Remaining& remaining);

// Error (io): fewer than `needed` bytes are free. No error where `free` is absent.
Status room_for_bytes(const std::filesystem::path& folder, double needed,
                      const std::optional<std::uint64_t>& free);

// What is there of the same work needs no room. A few pings are measured only where an estimate
// comes near what is free; what is worked out of the first world then is added to `first`. Errors:
// those of room_for_bytes and measure_pings.
Status room_for_work(const GenerateOptions& options, const SequenceWorlds& worlds,
                     const DatasetWork& work, const Numerics& numerics, int threads,
                     SharedParts& first);

// The same of runs, by their number in the sweep: from the estimates of their cost which, near what
// is free, are scaled by the size of the first run, measured. Error: that of room_for_bytes.
Status room_for_runs(const SweepOptions& options, const Sweep& sweep,
                     const std::vector<std::size_t>& runs, const Numerics& numerics, int threads);

}  // namespace ensonify
