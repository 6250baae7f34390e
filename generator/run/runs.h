// Making data sets and sweeps. Each returns nothing, or the error that the process ends with.
// Messages go to stderr.
//
//   generate  finalize_dataset
//   list_sweep  run_sweep  sweep_status  finalize_sweep
#pragma once

#include <cstddef>

#include "core/error.h"
#include "run/options.h"

namespace ensonify {

// Writes the data set, or resumes it. Error kinds: usage (nothing written), io, interrupted.
Status generate(const GenerateOptions& options);

// Writes the top level of a data set whose sequences were made by shards. Error kinds: usage
// (sequences are missing, or the folder has other work), io.
Status finalize_dataset(const GenerateOptions& options);

// Prints the plan of a sweep with the cost of each run, and writes nothing. Error kinds: usage
// (also if the plan in the folder has runs that this one does not have), io.
Status list_sweep(const SweepOptions& options);

// Makes the missing runs of the shard and returns how many of them failed; failures are reported on
// stderr and in a file for each. Error kinds: usage (nothing written); io, device and interrupted
// end the sweep.
Result<std::size_t> run_sweep(const SweepOptions& options);

// Prints the progress of the sweep in `output`, from its files. Error kinds: usage, io.
Status sweep_status(const SweepOptions& options);

// Writes the table of runs and the index. Error kinds: usage (runs are missing), io. With
// `leave_missing`, missing runs are no error and nothing is written: another process that looks
// into a finished run has it open for a moment, and writes the tables itself.
Status finalize_sweep(const SweepOptions& options, bool leave_missing = false);

}  // namespace ensonify
