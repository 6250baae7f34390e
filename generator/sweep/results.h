// What a finished run has to say in a table, read off its data set's files.
//
//   RunResults  read_results
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/error.h"

namespace ensonify {

// Absent where the data set holds no file that tells. Levels are dB re 1 uPa.
struct RunResults {
  std::optional<double> mean_level_db;     // of the mean of |p|^2 over all pixels of all pings
  std::optional<double> max_level_db;      // of the loudest pixel
  std::optional<double> noise_level_db;    // of the noise in every sample
  std::optional<double> first_return_m;    // mean over beams and pings that have one
  std::optional<double> labelled_px;       // pixels with a label, of the first picture of a ping
  std::optional<std::uint64_t> instances;  // that have a pixel in some picture
  // Of data sets with output.statistics: the mean over pixels with more than a hundredth of the
  // highest mean intensity, and its standard error.
  std::optional<double> contrast, contrast_se;
};

// From the series where they are kept, else from polar pictures (halves), else from
// statistics. Errors (io): a file is missing, cannot be read or is not as it should be.
Result<RunResults> read_results(const std::filesystem::path& dataset);

}  // namespace ensonify
