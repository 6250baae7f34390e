// What finishes a sweep: a table of its runs and an index. Both follow from the plan and the data
// sets alone, whoever made them and in whatever order.
//
//   FinishedRun   a run of the plan, with what its files say
//   runs_csv      DIR/runs.csv
//   index_json    DIR/index.json
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sweep/folder.h"
#include "sweep/plan.h"
#include "sweep/results.h"
#include "sweep/status.h"

namespace ensonify {

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
