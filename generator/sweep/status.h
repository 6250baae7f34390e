// The progress of a sweep, from the files in its folder alone.
//
//   RunState  RunStatus  run_status
//   SweepStatus  sum_up
//   status_text
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sweep/folder.h"

namespace ensonify {

enum class RunState {  // state_name has their names in this order
  missing,             // not begun
  begun,               // running or interrupted
  failed,              // and not finished since
  done,
  damaged  // finished, but files are missing or wrong: only finalizing reads them
};

// done, failed, running, missing, damaged
std::string state_name(RunState state);

struct RunStatus {
  RunState state = RunState::missing;
  std::uint64_t pings = 0;            // finished
  double begun_s = 0, changed_s = 0;  // of its pings, since 1970; 0: there are none
  double recent_pings = 0;            // finished within kRateSeconds before `now_s`
  std::optional<RunFailure> failure;  // of a failed run
};

// The speed is that of the last kRateSeconds. The pings of a finished run are assumed to be evenly
// distributed over the time in which the process that finished it worked on it.
inline constexpr double kSilentSeconds = 600, kRateSeconds = 600;

// `now_s`: since 1970.
RunStatus run_status(const std::filesystem::path& dir, const PlannedRun& run, double now_s);

struct SweepStatus {
  std::size_t runs = 0, done = 0, begun = 0, failed = 0, missing = 0;
  std::size_t silent = 0;  // of `begun`: without a new file for kSilentSeconds
  std::uint64_t pings = 0, pings_done = 0;
  std::uint64_t pings_to_come = 0;  // without those of failed runs
  std::optional<double> pings_per_s, seconds_left;
};

SweepStatus sum_up(const Plan& plan, const std::vector<RunStatus>& runs, double now_s);

// Some lines of text, with failed runs and their reasons last.
std::string status_text(const std::string& name, const Plan& plan,
                        const std::vector<RunStatus>& runs, const SweepStatus& status);

}  // namespace ensonify
