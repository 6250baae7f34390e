#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <semaphore>

#include "app/commands.h"
#include "app/cost.h"
#include "app/interrupt.h"
#include "app/numerics.h"
#include "app/progress.h"
#include "app/version.h"
#include "dataset/finish.h"
#include "dataset/sha256.h"
#include "dataset/work.h"
#include "dataset/write_ping.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

struct PingRange {
  std::uint32_t first = 0, last = 0;
};

Result<PingRange> range_of(const GenerateOptions& options, const Session& session) {
  const auto total = static_cast<std::uint32_t>(session.ping_times_s.size());
  if (!options.pings) return PingRange{0, total};
  const auto [first, last] = *options.pings;
  if (first < last && last <= total) return PingRange{first, last};
  return Error{ErrorKind::usage, fmt::format("--pings {}:{}: the scenario has pings 0 to {}; "
                                             "accepted is A:B with 0 <= A < B <= {}",
                                             first, last, total - 1, total)};
}

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

WorkIdentity identity_of(const Session& session, const std::vector<Asset>& assets, PingRange pings,
                         BackendChoice backend, SimdLevel simd, const Tracer& tracer) {
  // More sequences are the same work grown: the first ones stay as they are.
  Scenario without_count = session.scenario;
  without_count.sequences = 1;
  WorkIdentity identity;
  identity.name = session.scenario.name;
  identity.scenario_sha256 = sha256_hex(resolved_text(without_count, assets));
  identity.seed = session.scenario.seed;
  identity.first_ping = pings.first;
  identity.last_ping = pings.last;
  identity.program_version = program_version();
  identity.program_commit = program_commit();
  identity.backend = backend == BackendChoice::reference ? "reference" : "cpu";
  identity.simd = numerics_name(simd);
  identity.embree_isa = tracer.instruction_set();
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

struct Run {
  const GenerateOptions& options;
  const Session& session;
  const Tracer& tracer;
  const Workers& workers;
};

using Turns = std::counting_semaphore<>;

struct Turn {
  explicit Turn(Turns& all) : turns(all) { turns.acquire(); }
  ~Turn() { turns.release(); }
  Turns& turns;
};

// The processor's part of a ping, when it is its turn.
Result<EncodedPing> encoded_ping(const Pipeline& pipeline, std::uint32_t ping,
                                 const Workers& workers, Turns& turns) {
  const Turn turn(turns);
  return encode_ping(pipeline.info(), pipeline.run(ping, workers), workers);
}

Status make_ping(const Run& run, const Pipeline& pipeline, std::uint32_t ping,
                 const Workers& workers, Turns& turns) {
  if (interrupted()) {
    return Error{ErrorKind::interrupted,
                 "interrupted: what is finished is kept; the same command goes on from there"};
  }
  const Result<EncodedPing> encoded = encoded_ping(pipeline, ping, workers, turns);
  return encoded ? store_ping(run.options.output, pipeline.info(), *encoded)
                 : Status(encoded.error());
}

// Whole pings side by side while there are enough of them, in their order; threads beyond that work
// within each ping. A few pings more than threads are under way: the disk writes those while
// others are computed.
Status make_pings(const Run& run, const Pipeline& pipeline,
                  const std::vector<std::uint32_t>& missing, Progress& progress) {
  const int threads = run.workers.threads();
  const int side_by_side = static_cast<int>(std::min<std::size_t>(threads, missing.size()));
  if (side_by_side == 0) return {};
  const int lanes = pings_under_way(threads, missing.size());
  Turns turns(side_by_side);
  std::vector<Status> statuses(lanes);
  std::atomic<std::size_t> next = 0;
  Workers(lanes).for_each(lanes, [&](std::size_t lane) {
    const Workers within(threads / side_by_side);
    for (std::size_t i; (i = next.fetch_add(1)) < missing.size();) {
      statuses[lane] = make_ping(run, pipeline, missing[i], within, turns);
      if (!statuses[lane]) {
        next = missing.size();
        return;
      }
      progress.ping_done();
    }
  });
  for (const Status& status : statuses) {
    if (!status) return status;
  }
  return {};
}

std::vector<std::uint32_t> missing_pings(const fs::path& folder, const SequenceInfo& info) {
  std::vector<std::uint32_t> missing;
  for (std::uint32_t ping = info.first_ping; ping < info.last_ping; ++ping) {
    if (!ping_is_finished(folder, info.sequence, ping, info)) missing.push_back(ping);
  }
  return missing;
}

// All sequences, one after the other; their infos, for the finishing step. The pipeline's tables
// serve every sequence; it is made when the first ping is missing.
Result<std::vector<SequenceInfo>> make_sequences(const Run& run, PingRange pings,
                                                 std::optional<Pipeline> pipeline) {
  const std::uint32_t count = run.session.scenario.sequences;
  const std::uint64_t total = std::uint64_t{count} * (pings.last - pings.first);
  const auto info_of = [&](std::uint32_t s) {
    return sequence_info(run.session, s, pings.first, pings.last);
  };
  // Counted first and listed again below: a list of every ping of every sequence has no bound.
  std::uint64_t found = total;
  for (std::uint32_t s = 0; s < count; ++s) {
    found -= missing_pings(run.options.output, info_of(s)).size();
  }
  if (found > 0 && !run.options.quiet) {
    fmt::print(stderr, "continuing: {} of {} pings are there\n", found, total);
  }
  Progress progress(progress_style(run.options.quiet), total, found);
  std::vector<SequenceInfo> infos;
  for (std::uint32_t s = 0; s < count; ++s) {
    infos.push_back(info_of(s));
    if (sequence_is_finished(run.options.output, infos.back())) continue;
    if (!pipeline)
      pipeline.emplace(run.session, run.tracer, infos.back(),
                       Numerics{run.options.backend, run.options.simd});
    if (Status started = pipeline->start_sequence(infos.back(), run.workers); !started) {
      return started.error();
    }
    const std::vector<std::uint32_t> missing = missing_pings(run.options.output, infos.back());
    if (Status made = make_pings(run, *pipeline, missing, progress); !made) return made.error();
    if (Status finished = finish_sequence(run.options.output, pipeline->info()); !finished) {
      return finished.error();
    }
  }
  return infos;
}

std::string host_name() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

}  // namespace

Status generate(const GenerateOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Result<Scenario> scenario = load_scenario(options.input.scenario, options.input.overrides);
  if (!scenario) return scenario.error();
  Result<Session> session = prepare_session(std::move(*scenario));
  if (!session) return session.error();
  Result<PingRange> pings = range_of(options, *session);
  if (!pings) return pings.error();
  Result<std::vector<Asset>> assets = hash_assets(session->scenario);
  if (!assets) return assets.error();

  if (Status kept = keep_inputs(options, session->scenario); !kept) return kept;

  const Workers workers(options.threads);
  const Tracer tracer(session->world);
  DatasetInfo dataset;
  dataset.identity = identity_of(*session, *assets, *pings, options.backend, options.simd, tracer);
  // A noise.snr_db without an echo is a wrong scenario: found before anything is written.
  std::optional<Pipeline> pipeline;
  if (session->scenario.noise_snr_db) {
    const SequenceInfo info = sequence_info(*session, 0, pings->first, pings->last);
    pipeline.emplace(*session, tracer, info, Numerics{options.backend, options.simd});
    if (Status started = pipeline->start_sequence(info, workers); !started) return started;
  }
  Result<FolderState> state =
      open_work(options.output, dataset.identity, session->scenario.sequences, options.overwrite);
  if (!state) return state.error();
  if (*state == FolderState::complete) {
    if (!options.quiet) {
      fmt::print(stderr, "{}: complete already, nothing to do\n", options.output.string());
    }
    return {};
  }
  listen_for_interrupts();
  Result<std::vector<SequenceInfo>> sequences =
      make_sequences({options, *session, tracer, workers}, *pings, std::move(pipeline));
  if (!sequences) return sequences.error();

  dataset.scenario_yaml = resolved_text(session->scenario, *assets);
  dataset.sequences = std::move(*sequences);
  dataset.classes = session->world.classes;
  dataset.assets = std::move(*assets);
  dataset.host = host_name();
  dataset.threads = workers.threads();
  dataset.wall_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (Status finished = finish_dataset(options.output, dataset); !finished) return finished;
  if (!options.quiet) {
    fmt::print(stderr, "{}: {} pings in {} sequence{}\n", options.output.string(),
               std::uint64_t{session->scenario.sequences} * (pings->last - pings->first),
               session->scenario.sequences, session->scenario.sequences == 1 ? "" : "s");
  }
  return {};
}

}  // namespace ensonify
