// Is a data set whole?
//
//   verify_dataset
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "dataset/manifest.h"

namespace ensonify {

struct VerifyReport {
  std::vector<std::string> faults;  // one line each, in a fixed order; empty: all is whole
  std::size_t files = 0;            // that were looked at
  std::uint64_t bytes = 0;
  std::size_t sequences = 0;            // that dataset.json lists
  std::vector<SequenceFailure> failed;  // ... and those that could not be made, which is no fault
};

// Checks dataset.sha256, then every file that a manifest lists: there, of its size, hash, and shape
// and format as sequence.json says; the manifests' own form; tables and coco.json against the
// pings; and that no file is there which no manifest lists. Paths that leave the folder are faults
// and are not followed, and neither are links. provenance.json is not looked at. Error (io): the
// folder cannot be read; (usage): ensonify did not make it.
Result<VerifyReport> verify_dataset(const std::filesystem::path& dir, const Workers& workers);

}  // namespace ensonify
