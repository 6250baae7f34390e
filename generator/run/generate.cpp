#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <functional>
#include <utility>
#include <vector>

#include "core/counted.h"
#include "dataset/work.h"
#include "ping/pipeline.h"
#include "ping/scene_warnings.h"
#include "ping/tables.h"
#include "render/shown_images.h"
#include "run/disk_room.h"
#include "run/generate_parts.h"
#include "run/make_dataset.h"
#include "run/make_sequences.h"
#include "run/options.h"
#include "run/runs.h"
#include "run/sequence_worlds.h"
#include "run/terminal.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// A run must not delete its own input files.
Status keep_inputs(const GenerateOptions& options, const Scenario& scenario) {
  if (!options.overwrite) return {};
  const fs::path output = fs::weakly_canonical(options.output);
  std::vector<fs::path> inputs = input_files(scenario);
  if (fs::exists(options.input.scenario)) inputs.push_back(options.input.scenario);
  for (const fs::path& input : inputs) {
    const fs::path inside = fs::weakly_canonical(input).lexically_relative(output);
    if (inside.empty() || *inside.begin() == "..") continue;
    return Error{
        ErrorKind::usage,
        fmt::format("--overwrite: the input file {} would be deleted; expected it outside of {}",
                    input.string(), options.output.string())};
  }
  return {};
}

// A noise.snr_db without an echo is an error of the scenario if all sequences share one world, and
// is found before anything is written. Results of this check are passed on.
Result<SharedParts> calibrate_first(const Opened& opened, const Workers& workers) {
  const auto& worlds = opened.worlds;
  const SequenceInfo& info = opened.work.first;
  SharedParts shared;
  if (!info.noise_snr_db) return shared;
  shared.tables = pipeline_tables(worlds.first(), opened.numerics);
  const Result<Calibrated> made = calibrate(
      ping_setup(worlds.first(), worlds.first_tracer(), info, shared.tables), {}, workers);
  if (!made && made.error().kind == ErrorKind::usage && worlds.vary()) return shared;
  if (!made) return made.error();
  if (info.speckle != SpeckleMode::surface) shared.noise_power_pa2 = made->noise_power_pa2;
  return shared;
}

// Each instrument has its own numerics; they share the rest.
struct Crews {
  Turns turns;
  Progress progress;
  std::vector<Crew> list;

  Crews(const GenerateOptions& options, const std::vector<Opened>& parts, int threads,
        const PingTotals& pings)
      : turns(threads), progress(progress_style(options.quiet), pings.all, pings.found) {
    for (const Opened& part : parts) {
      list.push_back({part.numerics, threads, turns, progress});
      if (options.hooks != nullptr) list.back().stopped = options.hooks->stopped;
    }
  }
};

// Makes the parts that are not complete.
Status make(const GenerateOptions& options, std::vector<Opened>& parts, int threads) {
  PingTotals pings;
  for (const Opened& part : parts) {
    if (part.state == FolderState::complete) continue;
    const PingTotals own = ping_totals(part.options.output, part.worlds, part.work);
    pings.found += own.found;
    pings.all += own.all;
  }
  if (pings.all == 0) return {};  // a shard beyond the number of sequences
  if (pings.found > 0 && !options.quiet) {
    tell("resuming: {} of {} already made\n", pings.found, counted(pings.all, "ping"));
  }
  Crews crews(options, parts, threads, pings);
  std::function<void()> ping_done;
  std::atomic<std::uint64_t> done = pings.found;
  if (options.hooks != nullptr) {
    ping_done = [&] { options.hooks->progress(++done, pings.all); };
  }
  std::vector<SequenceJob> jobs;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    Opened& part = parts[i];
    if (part.state == FolderState::complete) continue;
    jobs.push_back(
        {crews.list[i], part.options.output, part.worlds, part.work, std::move(part.first)});
  }
  return make_sequences(jobs, 1, ping_done);
}

// The sequences of the shard are made; one process finishes the data set when all shards are done.
void tell_shard_is_done(const GenerateOptions& options, const DatasetWork& work,
                        std::size_t failed) {
  if (options.quiet) return;
  tell(
      "{}: shard {}/{}: {} of {} done; when all are done, the same command with --finalize instead "
      "of --shard finishes the data set\n",
      options.output.string(), options.shard->number, options.shard->count,
      counted(work.asked_count() - failed, "sequence"), work.sequences);
}

// Returns everything that prevents finishing, if anything does.
Status all_sequences_made(const GenerateOptions& options, const DatasetWork& work) {
  const Failures failed = failures_in(options.output);
  std::uint64_t missing = 0;
  std::uint32_t first = 0, last = 0;
  for (std::uint32_t sequence = 0; sequence < work.sequences; ++sequence) {
    if (failed.contains(sequence) || sequence_is_finished(options.output, sequence)) continue;
    if (missing++ == 0) first = sequence;
    last = sequence + 1;
  }
  if (missing == 0 || (options.partial && missing < work.sequences)) return {};
  return Error{
      ErrorKind::usage,
      fmt::format("{}: {} of {} missing; make them with --shard or --sequences {}:{}, which keep "
                  "finished ones{}",
                  options.output.string(), missing, counted(work.sequences, "sequence"), first,
                  last, options.partial ? "" : ", or give --partial to finish without them")};
}

// The sequences in [first, last) that cannot be made.
std::vector<SequenceFailure> failed_of(const GenerateOptions& options, const DatasetWork& work,
                                       PingRange sequences) {
  std::vector<SequenceFailure> failed = failures_of(options.output, work);
  std::erase_if(failed, [&](const SequenceFailure& failure) {
    return failure.sequence < sequences.first || failure.sequence >= sequences.second;
  });
  return failed;
}

// Error (incomplete) if sequences in [first, last) cannot be made.
Status unless_failed(const GenerateOptions& options, const DatasetWork& work, PingRange sequences) {
  const std::vector<SequenceFailure> failed = failed_of(options, work, sequences);
  if (failed.empty()) return {};
  return Error{ErrorKind::incomplete,
               fmt::format("{}: {}", options.output.string(),
                           failures_text(failed, sequences.second - sequences.first))};
}

using Clock = std::chrono::steady_clock;

Result<DatasetManifest> finish(const GenerateOptions& options, const Opened& opened,
                               Clock::time_point start) {
  const std::chrono::duration<double> took = Clock::now() - start;
  return finish_work(options.output, opened.worlds, opened.work, opened.threads, took.count());
}

void tell_finished(const GenerateOptions& options, const DatasetManifest& dataset,
                   PingRange asked) {
  if (options.quiet) return;
  std::uint64_t pings = 0, sequences = 0;
  for (const SequenceEntry& entry : dataset.sequences) {
    if (entry.sequence < asked.first || entry.sequence >= asked.second) continue;
    pings += entry.pings();
    ++sequences;
  }
  tell("{}: {} in {}\n", options.output.string(), counted(pings, "ping"),
       counted(sequences, "sequence"));
}

void warn_of_display(const GenerateOptions& options, const DatasetManifest& dataset) {
  if (!dataset.png) return;
  const std::string warning =
      display_warning(*dataset.png, dataset.png_counts, options.output.string());
  if (!warning.empty()) warn(options, warning);
}

// Finishes the data set when its sequences are made, or ends the shard.
Status end_work(const GenerateOptions& options, const Opened& opened, Clock::time_point start) {
  const DatasetWork& work = opened.work;
  if (options.shard) {
    tell_shard_is_done(options, work, failed_of(options, work, work.asked).size());
  } else {
    const Result<DatasetManifest> ended = finish(options, opened, start);
    if (!ended) return ended.error();
    warn_of_display(options, *ended);
    tell_finished(options, *ended, work.asked);
  }
  return unless_failed(options, work, work.asked);
}

}  // namespace

namespace {

Status finalize_part(Opened& opened, Clock::time_point start) {
  const GenerateOptions& options = opened.options;
  DatasetWork& work = opened.work;
  FolderUse use;
  const auto state = open_work(options.output, work.identity, work.sequences, false, false, &use);
  if (!state) return state.error();
  if (const Status there = all_sequences_made(options, work); !there) return there;
  std::uint32_t made = 0;
  for (std::uint32_t sequence = 0; sequence < work.sequences; ++sequence) {
    made += sequence_is_finished(options.output, sequence);
  }
  if (options.partial) work.asked = {0, 0};
  if (*state != FolderState::complete) {
    const Result<DatasetManifest> ended = finish(options, opened, start);
    if (!ended) return ended.error();
    warn_of_display(options, *ended);
  }
  if (!options.quiet) {
    tell("{}: finished with {} of {}\n", options.output.string(), made,
         counted(work.sequences, "sequence"));
  }
  return unless_failed(options, work, {0, work.sequences});
}

// Checks everything about a part that can be wrong before anything is written, and warns. `disk` is
// what the parts before it need.
Status check_part(Opened& opened, const Workers& workers, const std::string& name, double& disk) {
  auto& [options, worlds, numerics, work, threads, first, state, use] = opened;
  const Session& session = worlds.first();
  std::vector<std::string> warnings = all_warnings(session, worlds.first_tracer(), workers);
  if (options.shard) work.asked = range_of_shard(session.scenario.sequences, *options.shard);
  const auto unreadable = worlds.unreadable(work.pings, workers);
  if (!unreadable.empty()) {
    const auto looked_at = std::min(session.scenario.sequences, kSequencesChecked);
    warnings.push_back(failures_text(unreadable, looked_at));
  }
  for (const std::string& text : warnings) warn(options, name.empty() ? text : name + ": " + text);
  if (Status kept = keep_inputs(options, session.scenario); !kept) return kept;
  if (Status begins = worlds.begin_at(work.asked.first); !begins) return begins;
  Result<SharedParts> parts = calibrate_first(opened, workers);
  if (!parts) return parts.error();
  first = std::move(*parts);
  return room_for_work(options, worlds, work, disk);
}

Status check_parts(Parts& parts, const Workers& workers) {
  double disk = 0;
  for (std::size_t i = 0; i < parts.list.size(); ++i) {
    const std::string name = parts.names.empty() ? "" : parts.names[i];
    const Status fits = check_part(parts.list[i], workers, name, disk);
    if (!fits) {
      return of_part(parts, i, fits.error(), parts.list[i].options.input.scenario);
    }
  }
  return {};
}

// Makes the folders ready. Nothing has been written before.
Status open_folders(const GenerateOptions& options, Parts& parts) {
  if (!parts.names.empty()) {
    RigFile rig{parts.list.front().worlds.first().scenario.name, {}};
    for (const Opened& part : parts.list) {
      rig.instruments.push_back(rig_instrument(part.worlds.first()));
    }
    const Status opened = open_rig_folder(options.output, rig, options.overwrite);
    if (!opened) return opened;
  }
  for (Opened& part : parts.list) {
    const auto state = open_work(part.options.output, part.work.identity, part.work.sequences,
                                 options.overwrite, false, &part.use);
    if (!state) return state.error();
    part.state = *state;
  }
  return {};
}

// Calls `use` with each part. The first error that is not of its sequences alone ends it; of those
// the first is returned in the end.
Status for_each_part(Parts& parts, const std::function<Status(Opened&)>& use) {
  Status failed;
  for (Opened& part : parts.list) {
    Status status = use(part);
    if (!status && status.error().kind != ErrorKind::incomplete) return status;
    if (!status && failed) failed = std::move(status);
  }
  return failed;
}

int fewest_threads(const Parts& parts) {
  int threads = parts.list.front().threads;
  for (const Opened& part : parts.list) threads = std::min(threads, part.threads);
  return threads;
}

}  // namespace

Status finalize_dataset(const GenerateOptions& options) {
  const Clock::time_point start = Clock::now();
  if (std::error_code error; fs::is_empty(options.output, error) || error) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: contains no sequences; make them first, without --finalize",
                             options.output.string())};
  }
  Result<Parts> parts = open_parts(options, Pings::made);
  if (!parts) return parts.error();
  return for_each_part(*parts, [&](Opened& part) { return finalize_part(part, start); });
}

Status generate(const GenerateOptions& options) {
  if (options.hooks == nullptr) expect_interrupts();
  const Clock::time_point start = Clock::now();
  Result<Parts> parts = open_parts(options, Pings::wanted);
  if (!parts) return parts.error();
  const int threads = fewest_threads(*parts);
  const Workers workers(threads);
  if (Status fits = check_parts(*parts, workers); !fits) return fits;
  if (Status opened = open_folders(options, *parts); !opened) return opened;
  const auto is_complete = [](const Opened& part) { return part.state == FolderState::complete; };
  if (std::ranges::all_of(parts->list, is_complete)) {
    if (!options.quiet) {
      tell("{}: already complete, nothing to do\n", options.output.string());
    }
    return for_each_part(*parts, [](Opened& part) {
      return unless_failed(part.options, part.work, part.work.asked);
    });
  }
  if (options.hooks == nullptr) listen_for_interrupts();
  for (Opened& part : parts->list) {
    if (is_complete(part)) continue;
    const Status settled = settle_display(part.options.output, part.worlds, part.numerics, workers,
                                          part.work, part.first);
    if (!settled) return settled;
  }
  if (Status made = make(options, parts->list, threads); !made) return made;
  return for_each_part(*parts, [&](Opened& part) {
    return is_complete(part) ? unless_failed(part.options, part.work, part.work.asked)
                             : end_work(part.options, part, start);
  });
}

}  // namespace ensonify
