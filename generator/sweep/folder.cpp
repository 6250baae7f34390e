#include "sweep/folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <map>
#include <system_error>
#include <unordered_set>

#include "core/counted.h"
#include "dataset/layout.h"
#include "dataset/work.h"
#include "dataset/work_folder.h"
#include "formats/files.h"
#include "formats/json.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSweepFile = "sweep.json";
constexpr std::size_t kMaxFaultLines = 100;

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::symlink_status(path, error).type() != fs::file_type::not_found;
}

Error usage(const fs::path& path, const std::string& what) {
  return {ErrorKind::usage, fmt::format("{}: {}", path.string(), what)};
}

Status write_text(const fs::path& dir, const std::string& relative, const std::string& text) {
  const auto written = write_file_atomically(dir, relative, text);
  return written ? Status() : Status(written.error());
}

bool is_id(const std::string& text) {
  return text.size() == kRunIdDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

using NamedValues = std::vector<std::pair<std::string, std::string>>;

Json json_of(const NamedValues& values) {
  Json json = Json::object();
  for (const auto& [name, value] : values) json[name] = parse_shallow(value);
  return json;
}

NamedValues named_values(const Json& json) {
  NamedValues values;
  for (const auto& [name, value] : json.items()) values.emplace_back(name, value.dump());
  return values;
}

std::string line_of(const PlannedRun& run) {
  const Json line = {{"run", run.id},
                     {"name", run.name},
                     {"values", json_of(run.values)},
                     {"settings", json_of(run.settings)},
                     {"seed", run.seed},
                     {"pings", run.pings},
                     {"cost", run.cost}};
  return line.dump();
}

// What is wrong with a line; if empty, `run` is set.
std::string read_line(std::string_view text, PlannedRun& run) {
  const Json json = parse_shallow(text);
  if (!json.is_object()) return "is not a JSON object";
  for (const auto& [key, value] : json.items()) {
    const bool text_wanted = key == "run" || key == "name";
    const bool whole_wanted = key == "seed" || key == "pings";
    const bool fits = text_wanted     ? value.is_string()
                      : whole_wanted  ? value.is_number_unsigned()
                      : key == "cost" ? value.is_number() && std::isfinite(value.get<double>())
                                      : (key == "values" || key == "settings") && value.is_object();
    if (!fits) return fmt::format("its {} has another type than in a plan", shown(key));
  }
  for (const char* key : {"run", "name", "values", "seed", "pings", "cost"}) {
    if (!json.contains(key)) return fmt::format("has no {}", key);
  }
  run.id = json["run"].get<std::string>();
  run.name = json["name"].get<std::string>();
  run.values = named_values(json["values"]);
  // Plans of earlier versions have none.
  run.settings = named_values(json.value("settings", Json::object()));
  run.seed = json["seed"].get<std::uint64_t>();
  run.pings = json["pings"].get<std::uint64_t>();
  run.cost = json["cost"].get<double>();
  if (!is_id(run.id)) return fmt::format("{} is not the id of a run", shown(run.id));
  return run.cost >= 0 ? "" : "its cost is negative";
}

std::string failure_file(const std::string& id) { return "failed/" + id + ".json"; }

Status write_head(const fs::path& dir, const SweepHead& head) {
  const Json json = {
      {"ensonify_sweep_folder", 1},
      {"name", head.name},
      {"program", {{"version", head.program_version}, {"commit", head.program_commit}}}};
  return write_text(dir, kSweepFile, json_text(json));
}

Status check_head(const fs::path& dir, const std::optional<SweepHead>& old, const SweepHead& head) {
  if (!old) return {};
  const bool same =
      old->program_version == head.program_version && old->program_commit == head.program_commit;
  if (same) return {};
  return usage(
      dir,
      fmt::format(
          "ensonify {} ({}) began this sweep, and this is ensonify {} ({}); expected another "
          "folder, or --overwrite to resume this sweep (finished runs stay as they are)",
          old->program_version, old->program_commit, head.program_version, head.program_commit));
}

// Whether the folder has files of others. A folder without sweep.json may still have files of a
// sweep, from a start that was interrupted or from runs that were copied there.
bool holds_other_things(const fs::path& dir) {
  std::error_code error;
  for (fs::directory_iterator entry(dir, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name != layout::kWorkFolder && name != "runs" && name != "failed") return true;
  }
  return false;
}

// The state of the folder, if a sweep can be resumed there.
struct Held {
  std::optional<SweepHead> head;
  std::optional<Plan> plan;
};

Result<Held> look_at(const fs::path& dir, const SweepHead& head, const Plan& plan, bool overwrite) {
  std::error_code error;
  if (is_there(dir) && !fs::is_directory(dir, error)) return write_error(dir, ENOTDIR);
  if (is_there(dir / layout::kWorkJson) || is_there(dir / layout::kDatasetJson)) {
    return usage(dir, "is a data set; expected a new folder or the folder of this sweep");
  }
  auto old_head = read_sweep_head(dir);
  if (!old_head) return old_head.error();
  auto old_plan = read_plan(dir);
  if (!old_plan) return old_plan.error();
  if (!*old_head && !*old_plan && holds_other_things(dir)) {
    return usage(dir, "contains other files; expected a new folder or the folder of this sweep");
  }
  if (!overwrite) {
    if (Status same = check_head(dir, *old_head, head); !same) return same.error();
    if (*old_plan) {
      const Status grown = refuse_dropped(dir, compare_plans(**old_plan, plan));
      if (!grown) return grown.error();
    }
  }
  return Held{std::move(*old_head), std::move(*old_plan)};
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
    if (trouble.empty() && end == std::string_view::npos) trouble = "is incomplete";
    if (const auto [first, fresh] = seen.emplace(run.id, number); trouble.empty() && !fresh) {
      trouble = fmt::format("has the id of line {}", first->second);
    }
    if (!trouble.empty()) faults.push_back(fmt::format("{}:{}: {}", label, number, trouble));
    plan.push_back(std::move(run));
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
  if (faults.empty()) return plan;
  faults.push_back(
      fmt::format("{}: expected the plan that `ensonify sweep` wrote; remove the file so that it "
                  "is written again",
                  label));
  return Error{ErrorKind::usage, fmt::format("{}", fmt::join(faults, "\n"))};
}

Result<std::optional<Plan>> read_plan(const fs::path& dir) {
  const fs::path file = dir / kPlanFile;
  if (!is_there(file)) return std::optional<Plan>();
  const Result<std::string> text = read_file(file);
  if (!text) return text.error();
  Result<Plan> plan = parse_plan(*text, file.string());
  if (!plan) return plan.error();
  if (plan->empty()) {
    return usage(file, "contains no runs; remove the file and repeat the command of the sweep");
  }
  return std::optional(std::move(*plan));
}

Status write_plan(const fs::path& dir, const Plan& plan) {
  return write_text(dir, kPlanFile, to_jsonl(plan));
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
  const std::size_t dropped = change.dropped.size();
  return usage(dir, fmt::format("contains the plan of another sweep: {} of its {} {} not in this "
                                "one. A sweep may only gain runs; expected another folder, or "
                                "--overwrite to use the new plan (files of the old runs stay){}",
                                dropped, counted(dropped + change.kept, "run"),
                                dropped == 1 ? "is" : "are", named));
}

Result<std::optional<SweepHead>> read_sweep_head(const fs::path& dir) {
  const fs::path file = dir / kSweepFile;
  if (!is_there(file)) return std::optional<SweepHead>();
  const Result<std::string> text = read_file(file);
  if (!text) return text.error();
  const Json json = parse_shallow(*text);
  const auto name = text_at(json, "name");
  const Json program = json.is_object() ? json.value("program", Json()) : Json();
  const auto version = text_at(program, "version"), commit = text_at(program, "commit");
  if (!name || !version || !commit || json.value("ensonify_sweep_folder", Json()) != 1) {
    return usage(
        file,
        "was not written by this version of the program; remove the file or name another folder");
  }
  return std::optional(SweepHead{*name, *version, *commit});
}

Status open_sweep_folder(const fs::path& dir, const SweepHead& head, const Plan& plan,
                         bool overwrite) {
  std::error_code error;
  fs::create_directories(dir, error);
  if (error) return write_error(dir, error.value());
  const FolderLock lock(dir);
  const auto held = look_at(dir, head, plan, overwrite);
  if (!held) return held.error();
  if (held->head != head) {
    if (Status written = write_head(dir, head); !written) return written;
  }
  if (held->plan == plan) return {};
  // The tables are of the old plan.
  for (const char* table : {kIndexFile, kRunsFile}) fs::remove(dir / table, error);
  return write_plan(dir, plan);
}

Result<std::optional<PlanChange>> look_at_sweep_folder(const fs::path& dir, const SweepHead& head,
                                                       const Plan& plan, bool overwrite) {
  const FolderLock lock(dir);
  const auto held = look_at(dir, head, plan, overwrite);
  if (!held) return held.error();
  if (!held->plan) return std::optional<PlanChange>();
  PlanChange change = compare_plans(*held->plan, plan);
  change.dropped.clear();  // they refer to the old plan, which ends here
  return std::optional(std::move(change));
}

void close_sweep_folder(const fs::path& dir) {
  remove_work_folder(dir);
  std::error_code error;
  fs::remove(dir / "failed", error);  // only if it is empty
}

std::string run_folder(const std::string& id) { return "runs/" + id; }

bool run_is_done(const fs::path& dir, const std::string& id) {
  const fs::path folder = dir / run_folder(id);
  return is_sealed(folder) && !is_there(folder / layout::kWorkFolder);
}

std::string kind_name(ErrorKind kind) {
  constexpr const char* kNames[] = {"bug",         "damage",     "usage", "io",   "device",
                                    "interrupted", "incomplete", "usage", "usage"};
  return kNames[static_cast<std::size_t>(kind)];
}

Status write_failure(const fs::path& dir, const RunFailure& failure) {
  const Json json = {{"run", failure.run},   {"name", failure.name},
                     {"kind", failure.kind}, {"message", failure.message},
                     {"host", failure.host}, {"time_utc", failure.time_utc}};
  return write_text(dir, failure_file(failure.run), json_text(json));
}

std::optional<RunFailure> read_failure(const fs::path& dir, const std::string& id) {
  const fs::path file = dir / failure_file(id);
  if (!is_there(file)) return std::nullopt;
  const Result<std::string> text = read_file(file);
  if (!text) return std::nullopt;
  const Json json = parse_shallow(*text);
  const auto of = [&](const char* key) { return text_at(json, key).value_or(""); };
  if (of("kind").empty()) return std::nullopt;
  return RunFailure{id, of("name"), of("kind"), of("message"), of("host"), of("time_utc")};
}

void remove_failure(const fs::path& dir, const std::string& id) {
  ::unlink((dir / failure_file(id)).c_str());
}

}  // namespace ensonify
