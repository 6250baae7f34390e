// Sequences of a data set that cannot be made: each has a record in .work until dataset.json lists
// it.
//
//   Failures  failures_in
//   record_failure
//   sequence_numbers   of the sequences of which a folder has any file
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

// Failures in dataset.json, and those recorded since. Ignores unreadable records: these sequences
// are tried again.
Failures failures_in(const std::filesystem::path& dir);

// Error (io): it cannot be written.
Status record_failure(const std::filesystem::path& dir, const SequenceFailure& failure);

// In ascending order, without duplicates.
std::vector<std::uint32_t> sequence_numbers(const std::filesystem::path& dir);

}  // namespace ensonify
