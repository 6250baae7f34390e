#include "sweep/index.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "dataset/sha256.h"

namespace ensonify {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kBefore[] = {"run", "name"};
constexpr const char* kAfter[] = {
    "seed",           "pings",          "folder",      "status",    "mean_level_db", "max_level_db",
    "noise_level_db", "first_return_m", "labelled_px", "instances", "contrast",      "contrast_se"};

bool is_result(const std::string& name) {
  const auto same = [&](const char* other) { return name == other; };
  return std::any_of(std::begin(kBefore), std::end(kBefore), same) ||
         std::any_of(std::begin(kAfter), std::end(kAfter), same);
}

// Another name than all results and all other axes.
std::string column_of(const std::string& axis, const PlannedRun& run) {
  const auto is_axis = [&](const std::string& name) {
    return std::any_of(run.values.begin(), run.values.end(),
                       [&](const auto& value) { return value.first == name; });
  };
  std::string name = axis;
  while (is_result(name) || (name != axis && is_axis(name))) name = "axis_" + name;
  return name;
}

std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

// A text as it is, anything else as JSON.
std::string value_cell(const std::string& json_text) {
  const Json json = Json::parse(json_text, nullptr, false);
  return cell(json.is_string() ? json.get<std::string>() : json_text);
}

std::string number(const std::optional<double>& value) {
  return value ? fmt::format("{:.6g}", *value) : "";
}

std::string row_of(const PlannedRun& run, const FinishedRun& finished) {
  std::vector<std::string> cells = {run.id, cell(run.name)};
  for (const auto& [axis, value] : run.values) cells.push_back(value_cell(value));
  const RunResults& r = finished.results;
  cells.insert(cells.end(),
               {fmt::format("{}", run.seed), fmt::format("{}", run.pings), run_folder(run.id),
                state_name(finished.state), number(r.mean_level_db), number(r.max_level_db),
                number(r.noise_level_db), number(r.first_return_m), number(r.labelled_px),
                r.instances ? fmt::format("{}", *r.instances) : "", number(r.contrast),
                number(r.contrast_se)});
  return fmt::format("{}\n", fmt::join(cells, ","));
}

}  // namespace

std::string runs_csv(const Plan& plan, const std::vector<FinishedRun>& runs) {
  std::vector<std::string> columns(std::begin(kBefore), std::end(kBefore));
  if (!plan.empty()) {
    for (const auto& [axis, value] : plan.front().values)
      columns.push_back(column_of(axis, plan.front()));
  }
  columns.insert(columns.end(), std::begin(kAfter), std::end(kAfter));
  std::string text = fmt::format("{}\n", fmt::join(columns, ","));
  for (std::size_t i = 0; i < plan.size(); ++i) text += row_of(plan[i], runs[i]);
  return text;
}

std::string index_json(const SweepHead& head, const Plan& plan,
                       const std::vector<FinishedRun>& runs) {
  Json listed = Json::array(), failed = Json::array();
  std::size_t done = 0;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const FinishedRun& run = runs[i];
    const bool whole = run.state == RunState::done;
    done += whole;
    listed.push_back({{"run", plan[i].id},
                      {"name", plan[i].name},
                      {"status", state_name(run.state)},
                      {"folder", run_folder(plan[i].id)},
                      {"dataset_sha256", whole ? Json(run.dataset_sha256) : Json()}});
    if (!run.failure) continue;
    failed.push_back({{"run", plan[i].id},
                      {"name", plan[i].name},
                      {"kind", run.failure->kind},
                      {"message", run.failure->message}});
  }
  const Json json = {
      {"ensonify_sweep_index", 1},
      {"name", head.name},
      {"program", {{"version", head.program_version}, {"commit", head.program_commit}}},
      {"plan_sha256", sha256_hex(to_jsonl(plan))},
      {"complete", done == plan.size()},
      {"runs", std::move(listed)},
      {"failed", std::move(failed)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ensonify
