#include "sweep/folder.h"

#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>

#include <fmt/format.h>

#include "dataset/files.h"
#include "dataset/folder_lock.h"
#include "dataset/layout.h"
#include "dataset/shallow_json.h"
#include "dataset/work.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kSweepFile = "sweep.json";

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string failure_file(const std::string& id) { return "failed/" + id + ".json"; }

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::symlink_status(path, error).type() != fs::file_type::not_found;
}

std::optional<std::string> word(const Json& json, const char* key) {
  const auto found = json.is_object() ? json.find(key) : json.end();
  if (found == json.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

Error usage(const fs::path& path, const std::string& what) {
  return {ErrorKind::usage, fmt::format("{}: {}", path.string(), what)};
}

Status write_head(const fs::path& dir, const SweepHead& head) {
  const Json json = {
      {"ensonify_sweep_folder", 1},
      {"name", head.name},
      {"program", {{"version", head.program_version}, {"commit", head.program_commit}}}};
  const auto written = write_file_atomically(dir, kSweepFile, text_of(json));
  return written ? Status() : Status(written.error());
}

Status check_head(const fs::path& dir, const std::optional<SweepHead>& old, const SweepHead& head) {
  if (!old) return {};
  const bool same =
      old->program_version == head.program_version && old->program_commit == head.program_commit;
  if (same) return {};
  return usage(dir, fmt::format("ensonify {} ({}) began this sweep, and this is {} ({}); name "
                                "another folder, or give --overwrite to go on with this one (runs "
                                "that are done stay as they are)",
                                old->program_version, old->program_commit, head.program_version,
                                head.program_commit));
}

// Others' files. A folder without sweep.json may still hold what is called as ours is: of a start
// that was cut off, or runs that somebody brought.
bool holds_other_things(const fs::path& dir) {
  std::error_code error;
  for (fs::directory_iterator entry(dir, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name != layout::kWorkFolder && name != "runs" && name != "failed") return true;
  }
  return false;
}

// What stands in the folder, and may be gone on with.
struct Held {
  std::optional<SweepHead> head;
  std::optional<Plan> plan;
};

Result<Held> look_at(const fs::path& dir, const SweepHead& head, const Plan& plan, bool overwrite) {
  std::error_code error;
  if (is_there(dir) && !fs::is_directory(dir, error)) return write_error(dir, ENOTDIR);
  if (is_there(dir / layout::kWorkJson) || is_there(dir / layout::kDatasetJson)) {
    return usage(dir, "is a data set; accepted is a new folder, or that of this sweep");
  }
  auto old_head = read_sweep_head(dir);
  if (!old_head) return old_head.error();
  auto old_plan = read_plan(dir);
  if (!old_plan) return old_plan.error();
  if (!*old_head && !*old_plan && holds_other_things(dir)) {
    return usage(dir, "holds other things; accepted is a new folder, or that of this sweep");
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

Result<std::optional<SweepHead>> read_sweep_head(const fs::path& dir) {
  const fs::path file = dir / kSweepFile;
  if (!is_there(file)) return std::optional<SweepHead>();
  const Result<std::string> text = read_file(file);
  if (!text) return text.error();
  const Json json = parse_shallow<Json>(*text);
  const auto name = word(json, "name");
  const Json program = json.is_object() ? json.value("program", Json()) : Json();
  const auto version = word(program, "version"), commit = word(program, "commit");
  if (!name || !version || !commit || json.value("ensonify_sweep_folder", Json()) != 1) {
    return usage(file, "is not as this program writes it; remove it, or name another folder");
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
  return held->plan == plan ? Status() : write_plan(dir, plan);
}

Result<std::optional<PlanChange>> look_at_sweep_folder(const fs::path& dir, const SweepHead& head,
                                                       const Plan& plan, bool overwrite) {
  const FolderLock lock(dir);
  const auto held = look_at(dir, head, plan, overwrite);
  if (!held) return held.error();
  if (!held->plan) return std::optional<PlanChange>();
  PlanChange change = compare_plans(*held->plan, plan);
  change.dropped.clear();  // they go with the plan they are of
  return std::optional(std::move(change));
}

void close_sweep_folder(const fs::path& dir) {
  remove_work_folder(dir);
  std::error_code error;
  fs::remove(dir / "failed", error);  // where it is empty
}

std::string run_folder(const std::string& id) { return "runs/" + id; }

bool run_is_done(const fs::path& dir, const std::string& id) {
  const fs::path folder = dir / run_folder(id);
  return is_sealed(folder) && !is_there(folder / layout::kWorkFolder);
}

std::string kind_name(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::usage:
      return "usage";
    case ErrorKind::io:
      return "io";
    case ErrorKind::device:
      return "device";
    case ErrorKind::damage:
      return "damage";
    case ErrorKind::interrupted:
      return "interrupted";
    case ErrorKind::bug:
      break;
  }
  return "bug";
}

Status write_failure(const fs::path& dir, const RunFailure& failure) {
  const Json json = {{"run", failure.run},   {"name", failure.name},
                     {"kind", failure.kind}, {"message", failure.message},
                     {"host", failure.host}, {"time_utc", failure.time_utc}};
  const auto written = write_file_atomically(dir, failure_file(failure.run), text_of(json));
  return written ? Status() : Status(written.error());
}

std::optional<RunFailure> read_failure(const fs::path& dir, const std::string& id) {
  const fs::path file = dir / failure_file(id);
  if (!is_there(file)) return std::nullopt;
  const Result<std::string> text = read_file(file);
  if (!text) return std::nullopt;
  const Json json = parse_shallow<Json>(*text);
  const auto of = [&](const char* key) { return word(json, key).value_or(""); };
  if (of("kind").empty()) return std::nullopt;
  return RunFailure{id, of("name"), of("kind"), of("message"), of("host"), of("time_utc")};
}

void remove_failure(const fs::path& dir, const std::string& id) {
  ::unlink((dir / failure_file(id)).c_str());
}

}  // namespace ensonify
