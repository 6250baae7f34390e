// Checks a finished data set.
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
  std::vector<std::string> faults;  // one line each, in a fixed order; empty: none
  std::size_t files = 0;            // that were checked
  std::uint64_t bytes = 0;
  std::size_t sequences = 0;            // that dataset.json lists
  std::vector<SequenceFailure> failed;  // ... and those that could not be made, not an error
};

// Checks dataset.sha256, then for every listed file its presence, size and hash, and its shape and
// format against sequence.json; the form of the manifests; tables and coco.json against the pings;
// and that manifests list every file. Paths out of the folder and links are faults and are not
// followed. Ignores provenance.json. Error (io): the folder cannot be read; (usage): ensonify did
// not make it.
Result<VerifyReport> verify_dataset(const std::filesystem::path& dir, const Workers& workers);

}  // namespace ensonify
