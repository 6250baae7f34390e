#include <fmt/format.h>

#include <chrono>
#include <cstdio>

#include "app/commands.h"
#include "app/interrupt.h"
#include "app/make_dataset.h"
#include "app/make_sequences.h"
#include "app/numerics.h"
#include "app/pipeline.h"
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
    fmt::print(stderr, "backend: {}\n", numerics->backend_name);
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
  const std::uint64_t pings = ping_count(work.sequences());
  const std::uint64_t found = pings_found(options.output, work.sequences());
  if (found > 0 && !options.quiet) {
    fmt::print(stderr, "continuing: {} of {} pings are there\n", found, pings);
  }
  Progress progress(progress_style(options.quiet), pings, found);
  Turns turns(workers.threads());
  return make_sequences({numerics, workers.threads(), turns, progress}, options.output, worlds,
                        work.sequences());
}

}  // namespace

Status generate(const GenerateOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Result<SequenceWorlds> worlds = SequenceWorlds::open(options.input);
  if (!worlds) return worlds.error();
  for (const std::string& warning : worlds->first().world.warnings) {
    fmt::print(stderr, "warning: {}\n", warning);
  }
  const Scenario& scenario = worlds->first().scenario;
  const Result<Numerics> numerics = settled_numerics(options);
  if (!numerics) return numerics.error();
  const Workers workers(options.threads);
  FileHashes hashes;
  Result<DatasetWork> work =
      settle_dataset(*worlds, options.pings, options.sequences, *numerics, hashes, workers);
  if (!work) return work.error();
  for (const auto& text : starved_warnings(worlds->first(), worlds->first_tracer(), workers)) {
    fmt::print(stderr, "warning: {}\n", text);
  }
  if (Status kept = keep_inputs(options, scenario); !kept) return kept;
  if (Status heard = check_ping_zero(*worlds, work->infos.front(), *numerics, workers); !heard) {
    return heard;
  }
  const Result<FolderState> state =
      open_work(options.output, work->identity, scenario.sequences, options.overwrite);
  if (!state) return state.error();
  if (*state == FolderState::complete) {
    if (!options.quiet) {
      fmt::print(stderr, "{}: complete already, nothing to do\n", options.output.string());
    }
    return {};
  }
  listen_for_interrupts();
  if (Status made = make(options, *numerics, *worlds, *work, workers); !made) return made;

  const std::uint64_t pings = ping_count(work->sequences());
  const std::size_t sequences = work->sequences().size();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  const Status finished =
      finish_work(options.output, *worlds, std::move(*work), workers.threads(), took.count());
  if (!finished) return finished;
  if (!options.quiet) {
    fmt::print(stderr, "{}: {} pings in {} sequence{}\n", options.output.string(), pings, sequences,
               sequences == 1 ? "" : "s");
  }
  return {};
}

}  // namespace ensonify
