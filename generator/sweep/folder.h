// What stands in the folder of a sweep.
//
//   PlannedRun  Plan  to_jsonl  parse_plan  read_plan  write_plan   DIR/plan.jsonl: its runs in
//                                                      order, one line of JSON each
//   compare_plans  refuse_dropped                      a new plan beside the one that is there
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
  double cost = 0;  // seconds of a core, estimated

  friend bool operator==(const PlannedRun&, const PlannedRun&) = default;
};

using Plan = std::vector<PlannedRun>;  // no id twice

inline constexpr const char* kPlanFile = "plan.jsonl";

// The same runs give the same bytes.
std::string to_jsonl(const Plan& plan);

// Errors (usage): every line that is no run, `label:line: what is wrong`; an id given twice.
Result<Plan> parse_plan(std::string_view text, const std::string& label);

// Nothing where there is none. Errors: io, and those of parse_plan.
Result<std::optional<Plan>> read_plan(const std::filesystem::path& dir);

// By temporary name and rename: whoever writes the same plan at the same time does no harm.
Status write_plan(const std::filesystem::path& dir, const Plan& plan);

struct PlanChange {
  std::size_t kept = 0, added = 0;
  std::vector<const PlannedRun*> dropped;  // of the old plan, in its order
};
PlanChange compare_plans(const Plan& old, const Plan& now);

// Error (usage) where runs of the plan in `dir` would be dropped: how many, which, what to do.
Status refuse_dropped(const std::filesystem::path& dir, const PlanChange& change);

struct SweepHead {
  std::string name;
  std::string program_version, program_commit;

  friend bool operator==(const SweepHead&, const SweepHead&) = default;
};

// Nothing where there is none. Errors: usage (no sweep.json of this program), io.
Result<std::optional<SweepHead>> read_sweep_head(const std::filesystem::path& dir);

// Makes the folder, or looks at the one that is there, and writes sweep.json and plan.jsonl where
// they are not there as they should be. Processes that open it at the same time wait for each
// other. Errors: usage, where the folder is a data set or holds other things, where another program
// began the sweep, or where its plan has runs that this one has not, unless `overwrite`; then
// nothing is written. io.
Status open_sweep_folder(const std::filesystem::path& dir, const SweepHead& head, const Plan& plan,
                         bool overwrite);

// What it would refuse, and how the plan that is there, if any, would change (without `dropped`).
// Writes nothing; waits for whoever opens it, since a folder that is half begun looks like
// another's.
Result<std::optional<PlanChange>> look_at_sweep_folder(const std::filesystem::path& dir,
                                                       const SweepHead& head, const Plan& plan,
                                                       bool overwrite);

// Takes away temporary files. Others may be at work in the folder.
void close_sweep_folder(const std::filesystem::path& dir);

// runs/<id>
std::string run_folder(const std::string& id);

// Whether its data set is there, finished, and nothing of its making is left.
bool run_is_done(const std::filesystem::path& dir, const std::string& id);

struct RunFailure {
  std::string run, name;
  std::string kind;  // kind_name
  std::string message;
  std::string host, time_utc;  // where and when
};

// usage, io, ...
std::string kind_name(ErrorKind kind);

Status write_failure(const std::filesystem::path& dir, const RunFailure& failure);
// Nothing where there is none, or none that can be read.
std::optional<RunFailure> read_failure(const std::filesystem::path& dir, const std::string& id);
void remove_failure(const std::filesystem::path& dir, const std::string& id);

}  // namespace ensonify
