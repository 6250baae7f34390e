#include "sweep/status.h"

#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include <fmt/format.h>

#include "core/counted.h"
#include "dataset/layout.h"
#include "dataset/statistics.h"
#include "formats/files.h"
#include "formats/json.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// The time when a file was last written, in seconds since 1970.
std::optional<double> written_s(const fs::path& path) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0) return std::nullopt;
  return static_cast<double>(info.st_mtim.tv_sec) +
         1e-9 * static_cast<double>(info.st_mtim.tv_nsec);
}

bool is_record(const std::string& name) {
  return name.ends_with(".json") && name.find_first_not_of("0123456789") == name.size() - 5;
}

// Of pings without records, those of a finished run or realizations that are summed: the part since
// `recent_s`.
double recent_pings(const RunStatus& run, double recent_s) {
  if (run.changed_s <= recent_s) return 0;
  const double all_s = run.changed_s - run.begun_s;
  const double part = all_s > 0 ? (run.changed_s - std::max(run.begun_s, recent_s)) / all_s : 1;
  return static_cast<double>(run.pings) * std::clamp(part, 0.0, 1.0);
}

// Records of pings of one sequence, and its realizations, of which there may be no records.
void count_sequence(const fs::path& folder, double begun_s, double recent_s, RunStatus& status) {
  RunStatus summed;
  std::uint64_t records = 0;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const bool is_sum = entry->path().filename() == layout::kMoments;
    if (!is_sum && !is_record(entry->path().filename().string())) continue;
    const double at_s = written_s(entry->path()).value_or(0);
    status.changed_s = std::max(status.changed_s, at_s);
    if (is_sum) {
      summed.pings = realizations_in(entry->path());
      summed.begun_s = begun_s;
      summed.changed_s = at_s;
      continue;
    }
    ++records;
    status.recent_pings += at_s > recent_s;
  }
  status.pings += std::max(records, summed.pings);
  if (records == 0) status.recent_pings += recent_pings(summed, recent_s);
}

// Pings of an unfinished run.
void count_pings(const fs::path& folder, double begun_s, double recent_s, RunStatus& status) {
  std::error_code error;
  const fs::path sequences = folder / layout::kWorkFolder / "sequences";
  for (fs::directory_iterator sequence(sequences, error), end; !error && sequence != end;
       sequence.increment(error)) {
    count_sequence(sequence->path(), begun_s, recent_s, status);
  }
}

// How long the process that finished a run worked on it.
std::optional<double> wall_seconds(const fs::path& folder) {
  const Result<std::string> text = read_file(folder / layout::kProvenanceJson);
  if (!text) return std::nullopt;
  return number_at(parse_shallow(*text), "wall_seconds");
}

std::string duration_text(double seconds) {
  if (seconds < 60) return fmt::format("{:.0f} s", seconds);
  const long minutes = std::lround(seconds / 60);
  if (minutes < 60) return fmt::format("{} min", minutes);
  return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

}  // namespace

std::string state_name(RunState state) {
  constexpr const char* kNames[] = {"missing", "running", "failed", "done", "damaged"};
  return kNames[static_cast<std::size_t>(state)];
}

RunStatus run_status(const fs::path& dir, const PlannedRun& run, double now_s) {
  const double recent_s = now_s - kRateSeconds;
  const fs::path folder = dir / run_folder(run.id);
  RunStatus status;
  const auto begun = written_s(folder / layout::kWorkJson);
  if (run_is_done(dir, run.id)) {
    status.state = RunState::done;
    status.pings = run.pings;
    status.changed_s = written_s(folder / layout::kDatasetSha256).value_or(0);
    status.begun_s = status.changed_s - wall_seconds(folder).value_or(0);
    if (begun) status.begun_s = std::max(status.begun_s, *begun);
    status.recent_pings = recent_pings(status, recent_s);
    return status;
  }
  if (begun) {
    status.state = RunState::begun;
    count_pings(folder, *begun, recent_s, status);
    status.pings = std::min(status.pings, run.pings);
    status.begun_s = *begun;
    status.changed_s = std::max(status.changed_s, *begun);
  }
  status.failure = read_failure(dir, run.id);
  if (status.failure) status.state = RunState::failed;
  return status;
}

SweepStatus sum_up(const Plan& plan, const std::vector<RunStatus>& runs, double now_s) {
  SweepStatus sum;
  sum.runs = plan.size();
  double begun_s = now_s, recent = 0;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const RunStatus& run = runs[i];
    sum.done += run.state == RunState::done;
    sum.begun += run.state == RunState::begun;
    sum.failed += run.state == RunState::failed;
    sum.missing += run.state == RunState::missing;
    sum.silent += run.state == RunState::begun && now_s - run.changed_s > kSilentSeconds;
    sum.pings += plan[i].pings;
    sum.pings_done += run.pings;
    if (run.state != RunState::failed) sum.pings_to_come += plan[i].pings - run.pings;
    if (run.recent_pings > 0) begun_s = std::min(begun_s, run.begun_s);
    recent += run.recent_pings;
  }
  const double seconds = std::min(now_s - begun_s, kRateSeconds);
  if (recent > 0 && seconds > 0) {
    sum.pings_per_s = recent / seconds;
    sum.seconds_left = static_cast<double>(sum.pings_to_come) / *sum.pings_per_s;
  }
  return sum;
}

std::string status_text(const std::string& name, const Plan& plan,
                        const std::vector<RunStatus>& runs, const SweepStatus& status) {
  std::string text = fmt::format("{}: {}: {} done, {} running, {} failed, {} missing\n", name,
                                 counted(status.runs, "run"), status.done, status.begun,
                                 status.failed, status.missing);
  if (status.silent > 0) {
    text +=
        fmt::format("{} of the running runs wrote nothing for {} and may have been interrupted\n",
                    status.silent, duration_text(kSilentSeconds));
  }
  text += fmt::format("{} of {}", status.pings_done, counted(status.pings, "ping"));
  if (status.pings_to_come > 0 && status.pings_per_s) {
    text += fmt::format(", {:.3g} pings/s, {} left", *status.pings_per_s,
                        duration_text(*status.seconds_left));
  }
  text += "\n";
  for (std::size_t i = 0; i < plan.size(); ++i) {
    if (!runs[i].failure) continue;
    text += fmt::format("failed: {} {}: {}\n", plan[i].id, one_line(plan[i].name),
                        one_line(runs[i].failure->message));
  }
  return text;
}

}  // namespace ensonify
