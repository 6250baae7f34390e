#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <span>

#include "app/commands.h"
#include "app/interrupt.h"
#include "app/make_sequences.h"
#include "app/numerics.h"
#include "app/pipeline.h"
#include "app/sequence_worlds.h"
#include "app/starved_cells.h"
#include "app/version.h"
#include "dataset/finish.h"
#include "dataset/sha256.h"
#include "dataset/work.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

Result<std::vector<Asset>> hash_assets(const Scenario& scenario) {
  std::vector<Asset> assets;
  for (const fs::path& file : input_files(scenario)) {
    Result<std::string> hash = sha256_of_file(file);
    if (!hash) return hash.error();
    assets.push_back({*hash, file.extension().string(), file});
  }
  return assets;
}

// The resolved text as a data set holds it: input files by the hash of their content.
std::string resolved_text(const Scenario& scenario, const std::vector<Asset>& assets) {
  return to_yaml(scenario, [&](const fs::path& file) {
    for (const Asset& asset : assets) {
      if (asset.source == file) return "assets/" + asset.sha256 + asset.extension;
    }
    return file.string();
  });
}

WorkIdentity identity_of(const SequenceWorlds& worlds, const std::vector<Asset>& assets,
                         const SequenceInfo& first, const Numerics& numerics) {
  const Session& session = worlds.first();
  // More sequences are the same work grown: the first ones stay as they are.
  Scenario without_count = session.scenario;
  without_count.sequences = 1;
  WorkIdentity identity;
  identity.name = session.scenario.name;
  identity.scenario_sha256 = sha256_hex(resolved_text(without_count, assets));
  identity.seed = session.scenario.seed;
  identity.first_ping = first.first_ping;
  identity.last_ping = first.last_ping;
  identity.program_version = program_version();
  identity.program_commit = program_commit();
  identity.backend = numerics.backend_name;
  identity.simd = numerics_name(numerics.simd);
  identity.embree_isa = worlds.first_tracer().instruction_set();
  return identity;
}

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

Result<PingRange> sequences_of(const GenerateOptions& options, const Scenario& scenario) {
  if (!options.sequences) return PingRange{0, scenario.sequences};
  const auto [first, last] = *options.sequences;
  if (first < last && last <= scenario.sequences) return *options.sequences;
  return Error{ErrorKind::usage,
               fmt::format("--sequences {}:{}: the scenario has sequences 0 to {}; accepted is A:B "
                           "with 0 <= A < B <= {}",
                           first, last, scenario.sequences - 1, scenario.sequences)};
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

std::string host_name() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
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
  Result<PingRange> range = sequences_of(options, scenario);
  if (!range) return range.error();
  const Result<Numerics> numerics = settled_numerics(options);
  if (!numerics) return numerics.error();
  const Workers workers(options.threads);
  for (const auto& text : starved_warnings(worlds->first(), worlds->first_tracer(), workers)) {
    fmt::print(stderr, "warning: {}\n", text);
  }
  Result<std::vector<SequenceInfo>> infos = worlds->all_infos(options.pings, workers);
  if (!infos) return infos.error();
  Result<std::vector<Asset>> assets = hash_assets(scenario);
  if (!assets) return assets.error();
  if (Status kept = keep_inputs(options, scenario); !kept) return kept;
  if (Status heard = check_ping_zero(*worlds, infos->front(), *numerics, workers); !heard) {
    return heard;
  }

  DatasetInfo dataset;
  dataset.identity = identity_of(*worlds, *assets, infos->front(), *numerics);
  Result<FolderState> state =
      open_work(options.output, dataset.identity, scenario.sequences, options.overwrite);
  if (!state) return state.error();
  if (*state == FolderState::complete) {
    if (!options.quiet) {
      fmt::print(stderr, "{}: complete already, nothing to do\n", options.output.string());
    }
    return {};
  }
  listen_for_interrupts();
  const std::span<const SequenceInfo> asked =
      std::span(*infos).subspan(range->first, range->second - range->first);
  if (Status made = make_sequences(options, *numerics, *worlds, asked, workers); !made) return made;

  const std::uint64_t pings = ping_count(asked);
  for (SequenceInfo& info : *infos) {
    if (sequence_is_finished(options.output, info)) dataset.sequences.push_back(std::move(info));
  }
  dataset.scenario_yaml = resolved_text(scenario, *assets);
  dataset.classes = worlds->first().world.classes;
  dataset.assets = std::move(*assets);
  dataset.host = host_name();
  dataset.threads = workers.threads();
  dataset.wall_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::size_t sequences = asked.size();
  if (Status finished = finish_dataset(options.output, dataset); !finished) return finished;
  if (!options.quiet) {
    fmt::print(stderr, "{}: {} pings in {} sequence{}\n", options.output.string(), pings, sequences,
               sequences == 1 ? "" : "s");
  }
  return {};
}

}  // namespace ensonify
