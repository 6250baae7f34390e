// The whole comparison of two folders.
//
//   CompareOptions  compare_folders
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compare/compare.h"
#include "compare/read_pings.h"

namespace ensonify {

struct CompareOptions {
  std::filesystem::path real, simulated;
  Amount amount;
  std::filesystem::path mask_real, mask_simulated;          // empty: none
  std::optional<double> bottom_real_m, bottom_simulated_m;  // z of a flat bottom
  // Masks of classes, one for each ping, and the classes of labels that are objects (ClassSource).
  // Classes are compared if one of these is given.
  std::filesystem::path classes_real, classes_simulated;
  std::vector<std::string> objects;
  double gamma = 1;                  // of crops
  std::filesystem::path json, page;  // empty: not written
  // Beams that fire at once are so many apart. 0: the groups of sonar.transmit, or else those of an
  // ARIS with 48, 64, 96 or 128 beams, a sixteenth of them, and 8 with another number in the real
  // data.
  int comb_period = 0;
  std::uint64_t seed = 0;  // of the permutations
  int threads = 0;
  bool overwrite = false;  // may replace files that `ensonify compare` did not write
  bool (*stop)() = nullptr;
};

// Reads both, compares them, and writes the files that are asked for. Error kinds: usage (a folder
// or option that cannot be used), io, interrupted.
Result<Comparison> compare_folders(const CompareOptions& options);

}  // namespace ensonify
