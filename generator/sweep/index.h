// The files that finish a sweep: a table of its runs and an index. Both depend only on the plan and
// the data sets, and not on the processes that made the runs or on their order.
//
//   RunResults  read_results   measures of a finished run, from the files of its data set
//   FinishedRun                a run of the plan with the state of its files
//   runs_csv                   DIR/runs.csv
//   index_json                 DIR/index.json
//   has_whole_tables           whether both exist and are complete
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

// Absent if the data set has no file with the value. Levels are in dB re 1 uPa.
struct RunResults {
  std::optional<double> mean_level_db;     // of the mean of |p|^2 over all pixels of all pings
  std::optional<double> max_level_db;      // of the loudest pixel
  std::optional<double> noise_level_db;    // of the noise, per sample
  std::optional<double> first_return_m;    // mean over beams and pings that have one
  std::optional<double> labelled_px;       // pixels with a label, in the first image of a ping
  std::optional<std::uint64_t> instances;  // that have a pixel in any image
  // For data sets with output.statistics: the mean over pixels with more than a hundredth of the
  // highest mean intensity, and its standard error.
  std::optional<double> contrast, contrast_se;
};

// From the time series if they are stored, else from polar images (half floats), else from
// statistics. Errors (io): a file is missing, unreadable or damaged.
Result<RunResults> read_results(const std::filesystem::path& dataset);

// Whether both tables exist, and the index is of this plan with all runs done.
bool has_whole_tables(const std::filesystem::path& dir, const Plan& plan);

struct FinishedRun {
  RunState state = RunState::missing;
  std::string dataset_sha256;  // of its dataset.json; empty unless it is done
  RunResults results;          // empty unless it is done
  std::optional<RunFailure> failure;
};

// One line per run, in the order of the plan. An axis with the name of another column gets the
// prefix `axis_`. Lists, maps and texts with commas or quotes are quoted; absent numbers are empty.
std::string runs_csv(const Plan& plan, const std::vector<FinishedRun>& runs);

std::string index_json(const SweepHead& head, const Plan& plan,
                       const std::vector<FinishedRun>& runs);

}  // namespace ensonify
