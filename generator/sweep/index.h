// What finishes a sweep: a table of its runs and an index. Both follow from the plan and the data
// sets alone, whoever made them and in whatever order.
//
//   RunResults  read_results   what a finished run has to say, read off its data set's files
//   FinishedRun                a run of the plan, with what its files say
//   runs_csv                   DIR/runs.csv
//   index_json                 DIR/index.json
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "sweep/folder.h"
#include "sweep/status.h"

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

inline constexpr const char* kRunsFile = "runs.csv";
inline constexpr const char* kIndexFile = "index.json";

struct FinishedRun {
  RunState state = RunState::missing;
  std::string dataset_sha256;  // of its dataset.json; empty unless it is done
  RunResults results;          // empty unless it is done
  std::optional<RunFailure> failure;
};

// One line a run, in the order of the plan. An axis whose name is that of another column gets
// `axis_` before it. Lists, maps and texts with commas or quotes stand in quotes, absent numbers
// are empty.
std::string runs_csv(const Plan& plan, const std::vector<FinishedRun>& runs);

std::string index_json(const SweepHead& head, const Plan& plan,
                       const std::vector<FinishedRun>& runs);

}  // namespace ensonify
