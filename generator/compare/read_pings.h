// Reads what is compared from disk.
//
//   PingSource  read_pings   pings of a finished data set
//   CropSource  read_crops   a folder of images
//   is_dataset               which of the two a folder is
//
// Errors: (usage) nothing to measure, or another kind of file; (io) unreadable or damaged.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compare/pings.h"
#include "compare/read_classes.h"
#include "core/electronics.h"
#include "core/error.h"
#include "core/parallel.h"

namespace ensonify {

struct PingSource {
  std::filesystem::path dataset;
  Amount amount;
  std::filesystem::path mask;        // 8-bit PNG [samples, beams], 0: not used; empty: none
  std::optional<double> bottom_z_m;  // of a flat bottom, in the frame of the poses
  bool (*stop)() = nullptr;
  ClassSource classes = {};
};

struct ReadPings {
  PolarPings pings;
  std::vector<std::string> notes;    // what was not used
  std::optional<Recorder> recorder;  // of the counts that amplitudes follow from; absent: levels
};

// The pings of all sequences that have the grid of the first. With as many sequences as blocks or
// more a block is of one sequence.
Result<ReadPings> read_pings(const PingSource& source, const Workers& workers);

struct CropSource {
  std::filesystem::path folder;
  Amount amount;
  double gamma = 1;  // gray level = amplitude^gamma
  bool (*stop)() = nullptr;
};

struct ReadCrops {
  Crops crops;
  std::vector<std::string> notes;
};

// PNG and JPEG files of the folder and those in it, in the order of their paths; images of fewer
// than 24 pixels along a side are left out.
Result<ReadCrops> read_crops(const CropSource& source, const Workers& workers);

bool is_dataset(const std::filesystem::path& folder);

}  // namespace ensonify
