// The files in the folder of a sweep.
//
//   PlannedRun  Plan  to_jsonl  parse_plan  read_plan  write_plan   DIR/plan.jsonl: its runs in
//                                                      order, one line of JSON each
//   compare_plans  refuse_dropped                      a new plan next to the existing one
//   SweepHead  read_sweep_head                         DIR/sweep.json
//   open_sweep_folder  look_at_sweep_folder  close_sweep_folder
//   run_folder  run_is_done                            DIR/runs/<id>
//   RunFailure  write_failure  read_failure  remove_failure   DIR/failed/<id>.json
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"

namespace ensonify {

inline constexpr std::size_t kRunIdDigits = 16;

struct PlannedRun {
  std::string id;  // kRunIdDigits hexadecimal digits
  std::string name;
  std::vector<std::pair<std::string, std::string>> values;  // axis, its value as JSON
  std::uint64_t seed = 0;
  std::uint64_t pings = 0;
  double cost = 0;  // estimated seconds of one core
  std::vector<std::pair<std::string, std::string>> settings = {};  // key path, value as JSON

  friend bool operator==(const PlannedRun&, const PlannedRun&) = default;
};

using Plan = std::vector<PlannedRun>;  // no id twice

inline constexpr const char* kPlanFile = "plan.jsonl";
// Of index.h.
inline constexpr const char* kRunsFile = "runs.csv";
inline constexpr const char* kIndexFile = "index.json";

// The same runs give the same bytes.
std::string to_jsonl(const Plan& plan);

// Errors (usage): `label:line: what is wrong` for every line that is not a run or repeats an id.
Result<Plan> parse_plan(std::string_view text, const std::string& label);

// Empty if there is no plan. Errors: io, and those of parse_plan.
Result<std::optional<Plan>> read_plan(const std::filesystem::path& dir);

// Writes a temporary file and renames it, so that processes may write the same plan at the same
// time.
Status write_plan(const std::filesystem::path& dir, const Plan& plan);

struct PlanChange {
  std::size_t kept = 0, added = 0;
  std::vector<const PlannedRun*> dropped;  // of the old plan, in its order
};
PlanChange compare_plans(const Plan& old, const Plan& now);

// Error (usage) if runs of the plan in `dir` would be dropped: how many, which, and what to do.
Status refuse_dropped(const std::filesystem::path& dir, const PlanChange& change);

struct SweepHead {
  std::string name;
  std::string program_version, program_commit;

  friend bool operator==(const SweepHead&, const SweepHead&) = default;
};

// Empty if there is none. Errors: usage (no sweep.json of this program), io.
Result<std::optional<SweepHead>> read_sweep_head(const std::filesystem::path& dir);

// Creates the folder or checks the existing one, and writes sweep.json and plan.jsonl if they are
// missing or outdated. Processes that open it at the same time wait for each other. Errors: usage,
// if the folder is a data set or contains other files, another program began the sweep, or its plan
// has runs that this one does not have, unless `overwrite`; then nothing is written. io.
Status open_sweep_folder(const std::filesystem::path& dir, const SweepHead& head, const Plan& plan,
                         bool overwrite);

// Reports what open_sweep_folder would refuse, and how the existing plan, if any, would change
// (without `dropped`). Writes nothing; waits for processes that open the folder, because a folder
// that is half created looks like someone else's.
Result<std::optional<PlanChange>> look_at_sweep_folder(const std::filesystem::path& dir,
                                                       const SweepHead& head, const Plan& plan,
                                                       bool overwrite);

// Removes temporary files. Other processes may be working in the folder.
void close_sweep_folder(const std::filesystem::path& dir);

// runs/<id>
std::string run_folder(const std::string& id);

// Whether its data set is finished and no temporary files are left.
bool run_is_done(const std::filesystem::path& dir, const std::string& id);

struct RunFailure {
  std::string run, name;
  std::string kind;  // as kind_name spells it
  std::string message;
  std::string host, time_utc;  // where and when
};

// The name of the kind: usage, io, ...
std::string kind_name(ErrorKind kind);

Status write_failure(const std::filesystem::path& dir, const RunFailure& failure);
// Empty if there is none or it cannot be read.
std::optional<RunFailure> read_failure(const std::filesystem::path& dir, const std::string& id);
void remove_failure(const std::filesystem::path& dir, const std::string& id);

}  // namespace ensonify
