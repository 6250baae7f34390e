#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>

#include "core/counted.h"
#include "dataset/work.h"
#include "ping/pipeline.h"
#include "ping/scene_warnings.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "render/shown_images.h"
#include "run/disk_room.h"
#include "run/make_dataset.h"
#include "run/make_sequences.h"
#include "run/memory_room.h"
#include "run/options.h"
#include "run/runs.h"
#include "run/sequence_worlds.h"
#include "run/terminal.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

void warn(const GenerateOptions& options, std::string_view text) {
  if (options.hooks != nullptr) {
    options.hooks->warn(text);
  } else {
    tell("warning: {}\n", text);
  }
}

// The result of the common start of generate and finalize_dataset, which write nothing up to here.
struct Opened {
  SequenceWorlds worlds;
  Numerics numerics;
  DatasetWork work;
  int threads = 1;
};

enum class Pings { wanted, made };  // made: no memory is needed for them

Result<Opened> open_dataset(const GenerateOptions& options, Pings pings) {
  const bool checks = pings == Pings::wanted;
  Result<SequenceWorlds> worlds = SequenceWorlds::open_untraced(
      options.input, checks ? room_for_scenario : SequenceWorlds::ScenarioCheck());
  if (!worlds) return worlds.error();
  const Status room = checks ? room_for_world(worlds->first()) : Status();
  if (!room) return worlds->placed(room.error());
  worlds->trace_first();
  Result<Numerics> numerics = settled_numerics(options.backend, options.simd, options.quiet);
  if (!numerics) return numerics.error();
  const auto warns = [&](std::string_view text) { warn(options, text); };
  numerics = numerics_that_fit(worlds->first(), worlds->first_tracer(), *numerics, warns);
  if (!numerics) return worlds->placed(numerics.error());
  Result<int> threads = Workers(options.threads).threads();
  if (checks) {
    threads = threads_that_fit(worlds->first(), worlds->first_tracer(), *numerics, *threads, warns);
  }
  if (!threads) return worlds->placed(threads.error());
  FileHashes hashes;
  Result<DatasetWork> work =
      settle_dataset(*worlds, options.pings, options.sequences, *numerics, hashes);
  if (!work) return work.error();
  return Opened{std::move(*worlds), std::move(*numerics), std::move(*work), *threads};
}

// A run must not delete its own input files.
Status keep_inputs(const GenerateOptions& options, const Scenario& scenario) {
  if (!options.overwrite) return {};
  const fs::path output = fs::weakly_canonical(options.output);
  std::vector<fs::path> inputs = input_files(scenario);
  if (!options.input.text) inputs.push_back(options.input.scenario);
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
  const auto& [worlds, numerics, work, threads] = opened;
  const SequenceInfo& info = work.first;
  SharedParts shared;
  if (!info.noise_snr_db) return shared;
  shared.tables = pipeline_tables(worlds.first(), numerics);
  const Result<Calibrated> made = calibrate(
      ping_setup(worlds.first(), worlds.first_tracer(), info, shared.tables), {}, workers);
  if (!made && made.error().kind == ErrorKind::usage && worlds.vary()) return shared;
  if (!made) return made.error();
  if (info.speckle != SpeckleMode::surface) shared.noise_power_pa2 = made->noise_power_pa2;
  return shared;
}

Status make(const GenerateOptions& options, const Opened& opened, SharedParts first) {
  const auto& [worlds, numerics, work, threads] = opened;
  if (work.asked_count() == 0) return {};  // a shard beyond the number of sequences
  const PingTotals pings = ping_totals(options.output, worlds, work);
  if (pings.found > 0 && !options.quiet) {
    tell("resuming: {} of {} already made\n", pings.found, counted(pings.all, "ping"));
  }
  Progress progress(progress_style(options.quiet), pings.all, pings.found);
  Turns turns(threads);
  Crew crew{numerics, threads, turns, progress};
  std::function<void()> ping_done;
  std::atomic<std::uint64_t> done = pings.found;
  if (options.hooks != nullptr) {
    crew.stopped = options.hooks->stopped;
    ping_done = [&] { options.hooks->progress(++done, pings.all); };
  }
  return make_sequences(crew, options.output, worlds, work, 1, ping_done, std::move(first));
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

Status finalize_dataset(const GenerateOptions& options) {
  const Clock::time_point start = Clock::now();
  if (std::error_code error; fs::is_empty(options.output, error) || error) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: contains no sequences; make them first, without --finalize",
                             options.output.string())};
  }
  Result<Opened> opened = open_dataset(options, Pings::made);
  if (!opened) return opened.error();
  DatasetWork& work = opened->work;
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
    const Result<DatasetManifest> ended = finish(options, *opened, start);
    if (!ended) return ended.error();
    warn_of_display(options, *ended);
  }
  if (!options.quiet) {
    tell("{}: finished with {} of {}\n", options.output.string(), made,
         counted(work.sequences, "sequence"));
  }
  return unless_failed(options, work, {0, work.sequences});
}

Status generate(const GenerateOptions& options) {
  if (options.hooks == nullptr) expect_interrupts();
  const Clock::time_point start = Clock::now();
  Result<Opened> opened = open_dataset(options, Pings::wanted);
  if (!opened) return opened.error();
  auto& [worlds, numerics, work, threads] = *opened;
  const Workers workers(threads);
  const Session& session = worlds.first();
  std::vector<std::string> warnings = all_warnings(session, worlds.first_tracer(), workers);
  if (options.shard) work.asked = range_of_shard(session.scenario.sequences, *options.shard);
  const auto unreadable = worlds.unreadable(options.pings, workers);
  if (!unreadable.empty()) {
    const auto looked_at = std::min(session.scenario.sequences, kSequencesChecked);
    warnings.push_back(failures_text(unreadable, looked_at));
  }
  for (const std::string& text : warnings) warn(options, text);
  if (Status kept = keep_inputs(options, session.scenario); !kept) return kept;
  if (Status begins = worlds.begin_at(work.asked.first); !begins) return begins;
  Result<SharedParts> first = calibrate_first(*opened, workers);
  if (!first) return first.error();
  if (Status room = room_for_work(options, worlds, work); !room) return room;
  FolderUse use;
  const auto state = open_work(options.output, work.identity, session.scenario.sequences,
                               options.overwrite, false, &use);
  if (!state) return state.error();
  if (*state == FolderState::complete) {
    if (!options.quiet) {
      tell("{}: already complete, nothing to do\n", options.output.string());
    }
    return unless_failed(options, work, work.asked);
  }
  if (options.hooks == nullptr) listen_for_interrupts();
  const Status settled = settle_display(options.output, worlds, numerics, workers, work, *first);
  if (!settled) return settled;
  const Status made = make(options, *opened, std::move(*first));
  if (!made) return made;
  return end_work(options, *opened, start);
}

}  // namespace ensonify
