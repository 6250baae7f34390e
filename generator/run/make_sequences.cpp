#include "run/make_sequences.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <complex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/stage_times.h"
#include "dataset/finish.h"
#include "dataset/work_folder.h"
#include "dataset/write_ping.h"
#include "formats/files.h"
#include "ping/covisibility.h"
#include "ping/navigation_files.h"
#include "ping/scene_files.h"
#include "ping/sequence_info.h"
#include "run/cost.h"
#include "run/ensemble.h"
#include "run/terminal.h"

namespace ensonify {
namespace {

struct Run {
  const Crew& crew;
  const std::filesystem::path& dir;
  const SequenceWorlds& worlds;
  const DatasetWork& work;
  int beside;
  const std::function<void()>& told;
  SharedParts& first;  // known parts of the first world
  Failures failed;     // of earlier runs

  void ping_done() const {
    crew.progress.one_done();
    if (told) told();
  }
  // Threads per ping when several pings are made at the same time.
  int threads_within(int threads, std::size_t side_by_side) const {
    return std::max(1, threads / (static_cast<int>(side_by_side) * beside));
  }
};

std::uint64_t pings_of(const SequenceInfo& info) {
  return std::uint64_t{info.last_ping} - info.first_ping;
}

// The state of a lane between its sequences.
struct Workshop {
  ReadyWorld world;
  SharedParts shared;  // of the world
};

// Computes the ping up to its encoded files, when it is its turn to use the processor.
Result<EncodedPing> encoded_ping(const Run& run, const Pipeline& pipeline, std::uint32_t ping,
                                 PingStart start, const Workers& workers) {
  const Turn turn(run.crew.turns);
  return encode_ping(pipeline.info(), pipeline.run(ping, workers, std::move(start)), workers);
}

Status unless_interrupted(const Run& run) {
  if (!interrupted() && !(run.crew.stopped != nullptr && *run.crew.stopped)) return {};
  return Error{ErrorKind::interrupted,
               "interrupted: finished work is kept; repeat the command to resume"};
}

Status make_ping(const Run& run, const Pipeline& pipeline, std::uint32_t ping, PingStart start,
                 const Workers& workers) {
  if (Status go = unless_interrupted(run); !go) return go;
  const Result<EncodedPing> encoded = encoded_ping(run, pipeline, ping, std::move(start), workers);
  if (!encoded) return encoded.error();
  Status stored =
      timed(workers, Stage::store, [&] { return store_ping(run.dir, pipeline.info(), *encoded); });
  if (stored) run.ping_done();
  return stored;
}

// Makes a ping of an ensemble, stores it unless it is stored already, and returns its time series.
Result<Series> draw_ping(const Run& run, const Pipeline& pipeline, std::uint32_t ping,
                         const Workers& workers) {
  const SequenceInfo& info = pipeline.info();
  const bool stored = ping_is_finished(run.dir, info.sequence, ping, info);
  std::optional<Result<EncodedPing>> encoded;
  PingResult result;
  {
    const Turn turn(run.crew.turns);
    result = pipeline.run(ping, workers);
    if (!stored) encoded = encode_ping(info, result, workers);
  }
  if (encoded && !*encoded) return encoded->error();
  if (encoded) {
    if (Status kept = store_ping(run.dir, info, **encoded); !kept) return kept.error();
  }
  return std::move(result.series);
}

// The series of a block whose pings have files.
Status draw_and_store(const Run& run, const Pipeline& pipeline, PingRange pings,
                      const Workers& workers, std::vector<Series>& series) {
  for (std::uint32_t ping = pings.first; ping < pings.second; ++ping) {
    if (Status go = unless_interrupted(run); !go) return go;
    auto drawn = draw_ping(run, pipeline, ping, workers);
    if (!drawn) return drawn.error();
    series[ping - pings.first] = std::move(*drawn);
    run.ping_done();
  }
  return {};
}

// Of a block whose pings have no files. Nothing is recorded of them.
Status draw(const Run& run, const Pipeline& pipeline, PingRange pings, const Workers& workers,
            std::span<Series> series) {
  const auto at_once = static_cast<std::size_t>(pipeline.draws_at_once());
  for (std::size_t i = 0; i < series.size(); i += at_once) {
    if (Status go = unless_interrupted(run); !go) return go;
    const auto batch = series.subspan(i, std::min(at_once, series.size() - i));
    {
      const Turn turn(run.crew.turns);
      pipeline.draws(pings.first + static_cast<std::uint32_t>(i), workers, batch);
    }
    for (std::size_t done = 0; done < batch.size(); ++done) run.ping_done();
  }
  return {};
}

Status make_block(const Run& run, const Pipeline& pipeline, std::uint32_t block,
                  const Workers& workers, std::vector<Series>& series, Ensemble& ensemble) {
  const PingRange pings = ensemble.block_pings(block);
  series.resize(pings.second - pings.first);
  const Status drawn = pipeline.info().output.pings
                           ? draw_and_store(run, pipeline, pings, workers, series)
                           : draw(run, pipeline, pings, workers, series);
  if (!drawn) return drawn;
  const StageTimer timer(workers, Stage::moments);
  return ensemble.add(block, series);
}

// Makes whole pings in parallel and in order as long as there are enough of them; additional
// threads work within each ping. A few more pings than threads are in progress, so that the disk
// writes some while others are computed. `ping_zero`: the known part of ping 0.
Status make_pings(const Run& run, const Pipeline& pipeline,
                  const std::vector<std::uint32_t>& missing, int threads,
                  PingStart ping_zero = {}) {
  if (missing.empty()) return {};
  const int within = run.threads_within(threads, std::min<std::size_t>(threads, missing.size()));
  const int lanes = pings_under_way(threads, missing.size());
  return in_lanes(lanes, missing.size(), [&](std::size_t, std::size_t i) {
    PingStart start;
    if (missing[i] == 0) start = std::exchange(ping_zero, {});
    const Workers workers(within, run.crew.stage_times);
    return make_ping(run, pipeline, missing[i], std::move(start), workers);
  });
}

// Blocks whose series stay with the backend, which adds them as long as its memory suffices. Leaves
// the others.
Status make_blocks_there(const Run& run, const Pipeline& pipeline, int threads,
                         Ensemble& ensemble) {
  if (pipeline.info().output.pings || ensemble.blocks_done() == ensemble.block_count()) return {};
  const auto sums = moment_sums(pipeline.draw_parts(pipeline.info().first_ping), ensemble.moments(),
                                ensemble.pool());
  if (!sums) return {};
  const Workers workers(run.threads_within(threads, 1), run.crew.stage_times);
  return ensemble.follow(*sums, [&](PingRange pings) -> Result<std::uint32_t> {
    if (Status go = unless_interrupted(run); !go) return go.error();
    const Turn turn(run.crew.turns);
    const std::uint32_t added =
        add_draws(pipeline.draw_parts(pings.first), pings.second - pings.first, workers, *sums);
    for (std::uint32_t done = 0; done < added; ++done) run.ping_done();
    return added;
  });
}

// Blocks whose series the backend hands over. A block that does not finish, for whatever reason,
// must release the others.
Status make_blocks_here(const Run& run, const Pipeline& pipeline, int threads, Ensemble& ensemble) {
  struct Letting {
    Ensemble& ensemble;
    bool done = false;
    ~Letting() {
      if (!done) ensemble.give_up();
    }
  };
  const std::uint32_t first = ensemble.blocks_done();
  const std::size_t blocks = ensemble.block_count() - first;
  if (blocks == 0) return {};
  const int within = run.threads_within(threads, std::min<std::size_t>(threads, blocks));
  const int lanes = pings_under_way(threads, blocks);
  std::vector<std::vector<Series>> series(lanes);  // their memory serves block after block
  return in_lanes(lanes, blocks, [&](std::size_t lane, std::size_t i) {
    Letting letting{ensemble};
    const Workers workers(within, run.crew.stage_times);
    Status status = make_block(run, pipeline, first + static_cast<std::uint32_t>(i), workers,
                               series[lane], ensemble);
    letting.done = status.ok();
    return status;
  });
}

Status make_blocks(const Run& run, const Pipeline& pipeline, int threads, Ensemble& ensemble) {
  Status made = make_blocks_there(run, pipeline, threads, ensemble);
  if (made) made = make_blocks_here(run, pipeline, threads, ensemble);
  if (made || made.error().kind != ErrorKind::interrupted) return made;
  // Another process with the same work may have been faster and removed .work.
  if (sequence_is_finished(run.dir, pipeline.info().sequence)) return made;
  const Status saved = ensemble.save();
  return saved ? made : saved;
}

// The unfinished pings of [first_ping, last).
std::vector<std::uint32_t> missing_pings(const Run& run, const SequenceInfo& info,
                                         std::uint32_t last) {
  std::vector<std::uint32_t> missing;
  for (std::uint32_t ping = info.first_ping; ping < last; ++ping) {
    if (!ping_is_finished(run.dir, info.sequence, ping, info)) missing.push_back(ping);
  }
  return missing;
}

// The world of a sequence, with the known parts of the first world only. If all sequences share one
// world, it serves every sequence of the lane.
Status open_workshop(const Run& run, std::uint32_t sequence, const Workers& workers,
                     Workshop& workshop) {
  const bool vary = run.worlds.vary();
  if (workshop.world.session && !vary) return {};
  const Turn turn(run.crew.turns);
  workshop = {};  // frees the last world before the next one is built
  Result<ReadyWorld> world =
      timed(workers, Stage::world, [&] { return run.worlds.world(sequence); });
  if (!world) return world.error();
  workshop.world = std::move(*world);
  if (!vary) workshop.shared = run.first;
  if (vary && sequence == run.worlds.first_sequence())
    workshop.shared = std::exchange(run.first, {});
  return {};
}

Result<ReadyPipeline> start_sequence(const Run& run, std::uint32_t sequence, const Workers& workers,
                                     Workshop& workshop) {
  const Turn turn(run.crew.turns);
  const auto& [session, tracer] = workshop.world;
  const Result<PingRange> range = range_of(run.work.pings, *session);
  if (!range) return range.error();
  SequenceInfo info = sequence_info(*session, sequence, range->first, range->second);
  if (info.output.statistics) add_scene_keys(session->scenario, run.work.assets, info);
  info.png.limits_db = run.work.limits_db;
  const bool makes_ping_zero =
      info.first_ping == 0 && !ping_is_finished(run.dir, info.sequence, 0, info);
  return make_pipeline(*session, *tracer, std::move(info), run.crew.numerics, workers,
                       workshop.shared, makes_ping_zero);
}

// An error in one sequence does not prevent the others. A missing input file would affect all
// sequences and may reappear, so it ends the run.
Status give_up(const Run& run, std::uint32_t sequence, const Error& error) {
  if (error.kind == ErrorKind::final_usage) return of_sequence(sequence, error);
  if (error.kind != ErrorKind::usage) return error;
  for (const Asset& asset : run.work.assets) {
    if (::access(asset.source.c_str(), R_OK) != 0) return read_error(asset.source, errno);
  }
  run.crew.progress.correct_total(pings_of(run.work.first), 0);
  return record_failure(run.dir, {sequence, portable_text(error.message, run.work.assets)});
}

Result<std::string> sdf_of(const Run& run, const Session& session, const SequenceInfo& info) {
  if (!info.sdf) return std::string();
  const Turn turn(run.crew.turns);
  return scene_sdf(session, info);
}

Result<std::vector<float>> covisibility_of(const Run& run, const Session& session,
                                           const Pipeline& pipeline, int threads) {
  if (!pipeline.info().output.covisibility) return std::vector<float>();
  const Workers workers(run.threads_within(threads, 1), run.crew.stage_times);
  return covisibility(session, pipeline.tracer(), pipeline.info(), workers,
                      [&] { return unless_interrupted(run); });
}

// All pings of a sequence whose moments are kept.
Status make_ensemble(const Run& run, const Pipeline& pipeline, int threads, Ensemble& ensemble) {
  const SequenceInfo& info = pipeline.info();
  // Pings that have been added need only their files, if they have any.
  const std::uint32_t added =
      info.output.pings
          ? std::min(info.last_ping, info.first_ping + ensemble.blocks_done() * kMomentBlock)
          : info.first_ping;
  Status made = make_pings(run, pipeline, missing_pings(run, info, added), threads);
  return made ? make_blocks(run, pipeline, threads, ensemble) : made;
}

Status make_ready_sequence(const Run& run, ReadyPipeline& ready, int threads,
                           const Session& session) {
  const Pipeline& pipeline = ready.pipeline;
  const SequenceInfo& info = pipeline.info();
  run.crew.progress.correct_total(pings_of(run.work.first), pings_of(info));
  PooledPixels pool;
  std::optional<Ensemble> ensemble;
  if (info.output.statistics) {
    pool = pool_of(pipeline.expected_pa2(), info.output.statistics_within_db);
    ensemble.emplace(run.dir, info, pool);
  }
  Status made = ensemble ? make_ensemble(run, pipeline, threads, *ensemble)
                         : make_pings(run, pipeline, missing_pings(run, info, info.last_ping),
                                      threads, std::move(ready.ping_zero));
  if (!made) return made;
  const Result<std::string> sdf = sdf_of(run, session, info);
  if (!sdf) return sdf.error();
  const auto covisible = covisibility_of(run, session, pipeline, threads);
  if (!covisible) return covisible.error();
  PowerSpread spread;
  if (info.output.elevation && !info.sonar.array) spread = power_spread(info.sonar, info.record);
  const Workers workers(run.threads_within(threads, 1), run.crew.stage_times);
  const auto heights = scene_heights(session, pipeline.tracer(), info, workers,
                                     [&] { return unless_interrupted(run); });
  if (!heights) return heights.error();
  const std::vector<SceneObject> meshes = scene_meshes(session, info);
  return finish_sequence(
      run.dir, info,
      {*sdf, ensemble ? &ensemble->moments() : nullptr, &pool, pipeline.cartesian_map(), *covisible,
       spread.beam, spread.pulse,
       [&](const auto& append) { write_scene_ply(session.world, meshes, append); },
       [&](const auto& append) { write_scene_glb(session.world, meshes, append); }, *heights,
       write_sensor_tables(session, pipeline.tracer(), info),
       ensemble && !info.output.pings ? [&](std::uint32_t ping) { return pipeline.frame(ping); }
                                      : PingFrame()});
}

Status make_sequence(const Run& run, std::uint32_t sequence, int threads, Workshop& workshop) {
  if (run.failed.contains(sequence) || sequence_is_finished(run.dir, sequence)) return {};
  if (Status go = unless_interrupted(run); !go) return go;
  const Workers workers(run.threads_within(threads, 1), run.crew.stage_times);
  if (Status opened = open_workshop(run, sequence, workers, workshop); !opened) {
    return give_up(run, sequence, opened.error());
  }
  Result<ReadyPipeline> ready = start_sequence(run, sequence, workers, workshop);
  if (!ready) return give_up(run, sequence, ready.error());
  return make_ready_sequence(run, *ready, threads, *workshop.world.session);
}

std::uint64_t pings_found_of(const std::filesystem::path& dir, const SequenceInfo& info) {
  std::uint64_t found = 0;
  std::uint32_t last = info.last_ping;
  if (info.output.statistics) {
    const auto moments = load_moments(dir, info);
    const std::uint64_t added = moments ? moments->count : 0;
    if (!info.output.pings) return added;
    last = info.first_ping + static_cast<std::uint32_t>(added);
  }
  for (std::uint32_t ping = info.first_ping; ping < last; ++ping) {
    found += ping_is_finished(dir, info.sequence, ping, info);
  }
  return found;
}

}  // namespace

PingTotals ping_totals(const std::filesystem::path& dir, const SequenceWorlds& worlds,
                       const DatasetWork& work) {
  const std::uint64_t each = pings_of(work.first);
  const Failures failed = failures_in(dir);
  PingTotals totals{0, each * work.asked_count()};
  for (const std::uint32_t sequence : sequence_numbers(dir)) {
    if (sequence < work.asked.first || sequence >= work.asked.second) continue;
    if (const auto finished = finished_pings(dir, sequence)) {
      totals.found += *finished;
      totals.all += *finished - each;
    } else if (failed.contains(sequence)) {
      totals.all -= each;
    } else if (const auto info = worlds.info(sequence, work.pings)) {
      totals.found += pings_found_of(dir, *info);
    }
  }
  return totals;
}

Status make_sequences(std::span<SequenceJob> jobs, int beside,
                      const std::function<void()>& ping_done) {
  if (jobs.empty()) return {};
  std::vector<Run> runs;
  for (SequenceJob& job : jobs) {
    runs.push_back({job.crew, job.dir, job.worlds, job.work, beside, ping_done, job.first,
                    failures_in(job.dir)});
  }
  const Crew& crew = jobs.front().crew;
  const DatasetWork& work = jobs.front().work;
  const std::uint64_t sequences = work.asked_count() * jobs.size();
  const auto items =
      work_items(static_cast<std::uint32_t>(pings_of(work.first)), work.first.output);
  const int lanes =
      sequences_under_way(crew.threads, std::max(1u, items), sequences, jobs.front().worlds.vary());
  const int threads = std::max(1, crew.threads / lanes);
  std::vector<std::vector<Workshop>> workshops(lanes, std::vector<Workshop>(jobs.size()));
  return in_lanes(lanes, sequences, [&](std::size_t lane, std::size_t i) {
    const auto sequence = work.asked.first + static_cast<std::uint32_t>(i / jobs.size());
    const std::size_t job = i % jobs.size();
    // The world of another instrument is freed before one is built for the next sequence.
    for (std::size_t other = 0; other < jobs.size(); ++other) {
      if (other != job && runs[other].worlds.vary()) workshops[lane][other] = {};
    }
    return make_sequence(runs[job], sequence, threads, workshops[lane][job]);
  });
}

}  // namespace ensonify
