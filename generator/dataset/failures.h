// The sequences of a data set that cannot be made, whatever is tried: each has a record in .work
// until dataset.json lists it.
//
//   Failures  failures_in
//   record_failure
//   sequence_numbers   of the sequences that a folder has anything of
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/error.h"
#include "dataset/manifest.h"

namespace ensonify {

using Failures = std::map<std::uint32_t, std::string>;  // the error of each

// Those that dataset.json lists, and those recorded since. One that cannot be read is none: its
// sequence is tried again.
Failures failures_in(const std::filesystem::path& dir);

// Error (io): it cannot be written.
Status record_failure(const std::filesystem::path& dir, const SequenceFailure& failure);

// Ascending, each once.
std::vector<std::uint32_t> sequence_numbers(const std::filesystem::path& dir);

}  // namespace ensonify
