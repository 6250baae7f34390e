#include "sweep/plan.h"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <system_error>
#include <unordered_set>

#include <fmt/format.h>

#include "dataset/files.h"
#include "dataset/shallow_json.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxFaultLines = 100;

bool is_id(const std::string& text) {
  return text.size() == kRunIdDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::string line_of(const PlannedRun& run) {
  Json values = Json::object();
  for (const auto& [axis, value] : run.values) values[axis] = Json::parse(value);
  const Json line = {{"run", run.id},    {"name", run.name},   {"values", std::move(values)},
                     {"seed", run.seed}, {"pings", run.pings}, {"cost", run.cost}};
  return line.dump();
}

// What is wrong with a line; empty: nothing, and `run` is set.
std::string read_line(std::string_view text, PlannedRun& run) {
  const Json json = parse_shallow<Json>(text.begin(), text.end());
  if (!json.is_object()) return "is no JSON object";
  for (const auto& [key, value] : json.items()) {
    const bool text_wanted = key == "run" || key == "name";
    const bool whole_wanted = key == "seed" || key == "pings";
    const bool fits = text_wanted     ? value.is_string()
                      : whole_wanted  ? value.is_number_unsigned()
                      : key == "cost" ? value.is_number() && std::isfinite(value.get<double>())
                                      : key == "values" && value.is_object();
    if (!fits) return fmt::format("its {} is not as a plan's", shown(key));
  }
  for (const char* key : {"run", "name", "values", "seed", "pings", "cost"}) {
    if (!json.contains(key)) return fmt::format("lacks {}", key);
  }
  run.id = json["run"].get<std::string>();
  run.name = json["name"].get<std::string>();
  for (const auto& [axis, value] : json["values"].items()) {
    run.values.emplace_back(axis, value.dump());
  }
  run.seed = json["seed"].get<std::uint64_t>();
  run.pings = json["pings"].get<std::uint64_t>();
  run.cost = json["cost"].get<double>();
  if (!is_id(run.id)) return fmt::format("{} is no id of a run", shown(run.id));
  return run.cost >= 0 ? "" : "its cost is below zero";
}

}  // namespace

std::string to_jsonl(const Plan& plan) {
  std::string text;
  for (const PlannedRun& run : plan) text += line_of(run) + "\n";
  return text;
}

Result<Plan> parse_plan(std::string_view text, const std::string& label) {
  Plan plan;
  std::vector<std::string> faults;
  std::map<std::string, std::size_t> seen;
  std::size_t number = 0;
  while (!text.empty() && faults.size() < kMaxFaultLines) {
    ++number;
    const std::size_t end = text.find('\n');
    PlannedRun run;
    std::string trouble = read_line(text.substr(0, end), run);
    if (trouble.empty() && end == std::string_view::npos) trouble = "is cut off";
    if (const auto [first, fresh] = seen.emplace(run.id, number); trouble.empty() && !fresh) {
      trouble = fmt::format("has the id of line {}", first->second);
    }
    if (!trouble.empty()) faults.push_back(fmt::format("{}:{}: {}", label, number, trouble));
    plan.push_back(std::move(run));
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
  if (faults.empty()) return plan;
  faults.push_back(fmt::format(
      "{}: accepted is the plan that `ensonify sweep` wrote; remove it to have it made anew",
      label));
  return Error{ErrorKind::usage, fmt::format("{}", fmt::join(faults, "\n"))};
}

Result<std::optional<Plan>> read_plan(const fs::path& dir) {
  std::error_code error;
  const fs::path file = dir / kPlanFile;
  if (fs::symlink_status(file, error).type() == fs::file_type::not_found) {
    return std::optional<Plan>();
  }
  const Result<std::string> text = read_file(file);
  if (!text) return text.error();
  Result<Plan> plan = parse_plan(*text, file.string());
  if (!plan) return plan.error();
  if (plan->empty()) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: holds no run; remove it, and give the sweep's command again",
                             file.string())};
  }
  return std::optional(std::move(*plan));
}

Status write_plan(const fs::path& dir, const Plan& plan) {
  const auto written = write_file_atomically(dir, kPlanFile, to_jsonl(plan));
  return written ? Status() : written.error();
}

PlanChange compare_plans(const Plan& old, const Plan& now) {
  std::unordered_set<std::string_view> ids;
  for (const PlannedRun& run : now) ids.insert(run.id);
  PlanChange change;
  for (const PlannedRun& run : old) {
    if (ids.contains(run.id)) {
      ++change.kept;
    } else {
      change.dropped.push_back(&run);
    }
  }
  change.added = now.size() - change.kept;
  return change;
}

Status refuse_dropped(const fs::path& dir, const PlanChange& change) {
  if (change.dropped.empty()) return {};
  constexpr std::size_t kMaxNamed = 5;
  std::string named;
  for (std::size_t i = 0; i < change.dropped.size() && i < kMaxNamed; ++i) {
    named += fmt::format("\n  {} {}", change.dropped[i]->id, one_line(change.dropped[i]->name));
  }
  if (change.dropped.size() > kMaxNamed) named += "\n  ...";
  return Error{
      ErrorKind::usage,
      fmt::format("{}: holds the plan of another sweep: {} of its {} runs are not in this "
                  "one. A sweep may grow; name another folder, or give --overwrite to "
                  "take the new plan (what the old runs wrote stays){}",
                  dir.string(), change.dropped.size(), change.dropped.size() + change.kept, named)};
}

}  // namespace ensonify
