// The plan of a sweep: its runs in order, one line of JSON each.
//
//   PlannedRun  Plan
//   to_jsonl  parse_plan
//   kPlanFile  read_plan  write_plan   DIR/plan.jsonl
//   compare_plans  refuse_dropped      a new plan beside the one that is there
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

}  // namespace ensonify
