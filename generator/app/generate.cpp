#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "app/commands.h"
#include "app/interrupt.h"
#include "app/make_dataset.h"
#include "app/make_sequences.h"
#include "app/numerics.h"
#include "app/pipeline.h"
#include "app/print.h"
#include "app/sequence_worlds.h"
#include "app/starved_cells.h"
#include "dataset/work.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// A run must not remove what it reads.
Status keep_inputs(const GenerateOptions& options, const Scenario& scenario) {
  if (!options.overwrite) return {};
  const fs::path output = fs::weakly_canonical(options.output);
  std::vector<fs::path> inputs = input_files(scenario);
  inputs.push_back(options.input.scenario);
  for (const fs::path& input : inputs) {
    const fs::path inside = fs::weakly_canonical(input).lexically_relative(output);
    if (inside.empty() || *inside.begin() == "..") continue;
    return Error{ErrorKind::usage,
                 fmt::format("--overwrite would remove its own input {}; copy it out of {} first",
                             input.string(), options.output.string())};
  }
  return {};
}

// A noise.snr_db without an echo is a wrong scenario: found before anything is written.
Status check_ping_zero(const SequenceWorlds& worlds, const SequenceInfo& info,
                       const Numerics& numerics, const Workers& workers) {
  if (!worlds.first().scenario.noise_snr_db) return {};
  Pipeline pipeline(worlds.first(), worlds.first_tracer(), info, numerics);
  return pipeline.start_sequence(info, workers);
}

// A device is said aloud: `auto` took it.
Result<Numerics> settled_numerics(const GenerateOptions& options) {
  Result<Numerics> numerics = settle_backend(options.backend, options.simd);
  if (numerics && numerics->backend == BackendChoice::cuda && !options.quiet) {
    tell("backend: {}\n", numerics->backend_name);
  }
  return numerics;
}

std::uint64_t ping_count(std::span<const SequenceInfo> sequences) {
  std::uint64_t pings = 0;
  for (const SequenceInfo& info : sequences) pings += info.last_ping - info.first_ping;
  return pings;
}

Status make(const GenerateOptions& options, const Numerics& numerics, const SequenceWorlds& worlds,
            const DatasetWork& work, const Workers& workers) {
  if (work.sequences().empty()) return {};  // a shard of more shards than sequences
  const std::uint64_t pings = ping_count(work.sequences());
  const std::uint64_t found = pings_found(options.output, work.sequences());
  if (found > 0 && !options.quiet) {
    tell("continuing: {} of {} pings are there\n", found, pings);
  }
  Progress progress(progress_style(options.quiet), pings, found);
  Turns turns(workers.threads());
  return make_sequences({numerics, workers.threads(), turns, progress}, options.output, worlds,
                        work.sequences());
}

std::string plural(std::uint64_t sequences) {
  return fmt::format("{} sequence{}", sequences, sequences == 1 ? "" : "s");
}

// Its sequences are made; the data set is finished by one process, when all are.
void tell_shard_is_done(const GenerateOptions& options, const DatasetWork& work) {
  if (options.quiet) return;
  tell(
      "{}: shard {}/{}: {} of {} done; once all are, the same command with --finalize in "
      "place of --shard finishes the data set\n",
      options.output.string(), options.shard->number, options.shard->count,
      plural(work.sequences().size()), work.infos.size());
}

// All that stand in the way of finishing, or none.
Status all_sequences_made(const GenerateOptions& options, const DatasetWork& work) {
  std::uint64_t missing = 0;
  std::uint32_t first = 0, last = 0;
  for (const SequenceInfo& info : work.infos) {
    if (sequence_is_finished(options.output, info)) continue;
    if (missing++ == 0) first = info.sequence;
    last = info.sequence + 1;
  }
  if (missing == 0 || (options.partial && missing < work.infos.size())) return {};
  return Error{
      ErrorKind::usage,
      fmt::format("{}: {} of {} missing; make them (--shard, or --sequences {}:{}, which leaves "
                  "alone what is done){}",
                  options.output.string(), missing, plural(work.infos.size()), first, last,
                  options.partial ? "" : ", or give --partial for those that are there")};
}

}  // namespace

Status finalize_dataset(const GenerateOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  if (std::error_code error; fs::is_empty(options.output, error) || error) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: holds no sequences; make them first, without --finalize",
                             options.output.string())};
  }
  Result<SequenceWorlds> worlds = SequenceWorlds::open(options.input);
  if (!worlds) return worlds.error();
  const Result<Numerics> numerics = settled_numerics(options);
  if (!numerics) return numerics.error();
  const Workers workers(options.threads);
  FileHashes hashes;
  Result<DatasetWork> work =
      settle_dataset(*worlds, options.pings, std::nullopt, *numerics, hashes, workers);
  if (!work) return work.error();
  FolderUse use;
  const Result<FolderState> state = open_work(
      options.output, work->identity, worlds->first().scenario.sequences, false, false, &use);
  if (!state) return state.error();
  if (const Status there = all_sequences_made(options, *work); !there) return there;
  const std::size_t all = work->infos.size();
  const auto made = std::count_if(work->infos.begin(), work->infos.end(), [&](const auto& info) {
    return sequence_is_finished(options.output, info);
  });
  if (options.partial) work->asked = {0, 0};
  if (*state != FolderState::complete) {
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    const Status finished =
        finish_work(options.output, *worlds, std::move(*work), workers.threads(), took.count());
    if (!finished) return finished;
  }
  if (!options.quiet) {
    tell("{}: finished with {} of {}\n", options.output.string(), made, plural(all));
  }
  return {};
}

Status generate(const GenerateOptions& options) {
  expect_interrupts();
  const auto start = std::chrono::steady_clock::now();
  Result<SequenceWorlds> worlds = SequenceWorlds::open(options.input);
  if (!worlds) return worlds.error();
  for (const std::string& warning : worlds->first().world.warnings) {
    tell("warning: {}\n", warning);
  }
  const Scenario& scenario = worlds->first().scenario;
  const Result<Numerics> numerics = settled_numerics(options);
  if (!numerics) return numerics.error();
  const Workers workers(options.threads);
  FileHashes hashes;
  Result<DatasetWork> work =
      settle_dataset(*worlds, options.pings, options.sequences, *numerics, hashes, workers);
  if (!work) return work.error();
  if (options.shard) work->asked = range_of_shard(scenario.sequences, *options.shard);
  for (const auto& text : starved_warnings(worlds->first(), worlds->first_tracer(), workers)) {
    tell("warning: {}\n", text);
  }
  if (Status kept = keep_inputs(options, scenario); !kept) return kept;
  if (Status heard = check_ping_zero(*worlds, work->infos.front(), *numerics, workers); !heard) {
    return heard;
  }
  FolderUse use;
  const Result<FolderState> state =
      open_work(options.output, work->identity, scenario.sequences, options.overwrite, false, &use);
  if (!state) return state.error();
  if (*state == FolderState::complete) {
    if (!options.quiet) {
      tell("{}: complete already, nothing to do\n", options.output.string());
    }
    return {};
  }
  listen_for_interrupts();
  if (Status made = make(options, *numerics, *worlds, *work, workers); !made) return made;

  if (options.shard) {
    tell_shard_is_done(options, *work);
    return {};
  }
  const std::uint64_t pings = ping_count(work->sequences());
  const std::size_t sequences = work->sequences().size();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  const Status finished =
      finish_work(options.output, *worlds, std::move(*work), workers.threads(), took.count());
  if (!finished) return finished;
  if (!options.quiet) {
    tell("{}: {} pings in {}\n", options.output.string(), pings, plural(sequences));
  }
  return {};
}

}  // namespace ensonify
