#include "app/make_sequences.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <memory>
#include <semaphore>
#include <vector>

#include "app/cost.h"
#include "app/interrupt.h"
#include "app/pipeline.h"
#include "app/progress.h"
#include "dataset/finish.h"
#include "dataset/write_ping.h"

namespace ensonify {
namespace {

using Turns = std::counting_semaphore<>;

// As many at once as there are threads.
struct Turn {
  explicit Turn(Turns& all) : turns(all) { turns.acquire(); }
  ~Turn() { turns.release(); }
  Turns& turns;
};

struct Run {
  const GenerateOptions& options;
  const Numerics& numerics;
  const SequenceWorlds& worlds;
  Turns& turns;
  Progress& progress;
};

// One sequence being made: its world and what computes its pings.
struct Workshop {
  ReadyWorld world;
  std::unique_ptr<Pipeline> pipeline;
};

// The processor's part of a ping, when it is its turn.
Result<EncodedPing> encoded_ping(const Run& run, const Pipeline& pipeline, std::uint32_t ping,
                                 const Workers& workers) {
  const Turn turn(run.turns);
  return encode_ping(pipeline.info(), pipeline.run(ping, workers), workers);
}

Status make_ping(const Run& run, const Pipeline& pipeline, std::uint32_t ping,
                 const Workers& workers) {
  if (interrupted()) {
    return Error{ErrorKind::interrupted,
                 "interrupted: what is finished is kept; the same command goes on from there"};
  }
  const Result<EncodedPing> encoded = encoded_ping(run, pipeline, ping, workers);
  if (!encoded) return encoded.error();
  Status stored = store_ping(run.options.output, pipeline.info(), *encoded);
  if (stored) run.progress.ping_done();
  return stored;
}

// Calls work(lane, i) for i = 0 ... count - 1, in this order, from `lanes` lanes at once, until one
// fails.
template <class Work>
Status in_lanes(int lanes, std::size_t count, Work work) {
  std::vector<Status> statuses(lanes);
  std::atomic<std::size_t> next = 0;
  Workers(lanes).for_each(lanes, [&](std::size_t lane) {
    for (std::size_t i; (i = next.fetch_add(1)) < count;) {
      statuses[lane] = work(lane, i);
      if (!statuses[lane]) {
        next = count;
        return;
      }
    }
  });
  for (const Status& status : statuses) {
    if (!status) return status;
  }
  return {};
}

// Whole pings side by side while there are enough of them, in their order; threads beyond that work
// within each ping. A few pings more than threads are under way: the disk writes those while
// others are computed.
Status make_pings(const Run& run, const Pipeline& pipeline,
                  const std::vector<std::uint32_t>& missing, int threads) {
  if (missing.empty()) return {};
  const int side_by_side = static_cast<int>(std::min<std::size_t>(threads, missing.size()));
  const int lanes = pings_under_way(threads, missing.size());
  return in_lanes(lanes, missing.size(), [&](std::size_t, std::size_t i) {
    return make_ping(run, pipeline, missing[i], Workers(threads / side_by_side));
  });
}

std::vector<std::uint32_t> missing_pings(const Run& run, const SequenceInfo& info) {
  std::vector<std::uint32_t> missing;
  for (std::uint32_t ping = info.first_ping; ping < info.last_ping; ++ping) {
    if (!ping_is_finished(run.options.output, info.sequence, ping, info)) missing.push_back(ping);
  }
  return missing;
}

// The world and pipeline of a sequence. Where all share one world, its tables serve every sequence
// of the lane.
Status open_workshop(const Run& run, const SequenceInfo& info, Workshop& workshop) {
  if (workshop.pipeline && !run.worlds.vary()) return {};
  const Turn turn(run.turns);
  workshop.pipeline.reset();
  workshop.world = {};  // the last world goes before the next one comes
  Result<ReadyWorld> world = run.worlds.world(info.sequence);
  if (!world) return world.error();
  workshop.world = std::move(*world);
  workshop.pipeline =
      std::make_unique<Pipeline>(*workshop.world.session, *workshop.world.tracer, info,
                                 run.numerics);
  return {};
}

// The scene at the sequence's first ping; nothing where it is not asked for.
Result<std::string> sdf_of(const Run& run, const Session& session, const SequenceInfo& info) {
  if (!info.sdf) return std::string();
  const Turn turn(run.turns);
  Result<std::string> sdf =
      scene_sdf_vdb(session.world, object_poses(session, info.first_ping), *info.sdf,
                    reach_of(session, info.first_ping, info.last_ping));
  if (!sdf) return Error{sdf.error().kind, "output.sdf: " + sdf.error().message};
  return sdf;
}

Status make_sequence(const Run& run, const SequenceInfo& light, int threads, Workshop& workshop) {
  if (sequence_is_finished(run.options.output, light)) return {};
  if (Status opened = open_workshop(run, light, workshop); !opened) return opened;
  const SequenceInfo info =
      sequence_info(*workshop.world.session, light.sequence, light.first_ping, light.last_ping);
  const Workers workers(threads);
  {
    const Turn turn(run.turns);
    Status started = workshop.pipeline->start_sequence(info, workers);
    if (!started) return started;
  }
  Status made = make_pings(run, *workshop.pipeline, missing_pings(run, info), threads);
  if (!made) return made;
  const Result<std::string> sdf = sdf_of(run, *workshop.world.session, info);
  return sdf ? finish_sequence(run.options.output, workshop.pipeline->info(), *sdf)
             : Status(sdf.error());
}

int sequences_at_once(std::span<const SequenceInfo> sequences, int threads) {
  std::uint32_t pings = 1;
  for (const SequenceInfo& info : sequences) {
    pings = std::max(pings, info.last_ping - info.first_ping);
  }
  return sequences_under_way(threads, pings, sequences.size());
}

}  // namespace

Status make_sequences(const GenerateOptions& options, const Numerics& numerics,
                      const SequenceWorlds& worlds,
                      std::span<const SequenceInfo> sequences, const Workers& workers) {
  std::uint64_t total = 0, found = 0;
  for (const SequenceInfo& info : sequences) {
    total += info.last_ping - info.first_ping;
    for (std::uint32_t ping = info.first_ping; ping < info.last_ping; ++ping) {
      found += ping_is_finished(options.output, info.sequence, ping, info);
    }
  }
  if (found > 0 && !options.quiet) {
    fmt::print(stderr, "continuing: {} of {} pings are there\n", found, total);
  }
  Progress progress(progress_style(options.quiet), total, found);
  Turns turns(workers.threads());
  const Run run{options, numerics, worlds, turns, progress};
  const int lanes = sequences_at_once(sequences, workers.threads());
  const int threads = std::max(1, workers.threads() / lanes);
  std::vector<Workshop> workshops(lanes);
  return in_lanes(lanes, sequences.size(), [&](std::size_t lane, std::size_t i) {
    return make_sequence(run, sequences[i], threads, workshops[lane]);
  });
}

}  // namespace ensonify
