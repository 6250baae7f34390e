#include <memory>
#include <utility>

#include "cli/commands.h"
#include "core/counted.h"
#include "ping/object_looks.h"
#include "ping/scene_warnings.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "run/cost.h"
#include "run/disk_room.h"
#include "run/make_dataset.h"
#include "run/measure.h"
#include "run/memory.h"
#include "run/sequence_worlds.h"
#include "run/sweep_parts.h"
#include "run/terminal.h"
#include "run/world_census.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// This many pings of a sequence are enough for a mean.
constexpr std::uint32_t kMeasuredPerThread = 16;

void answer_scenario(const Session& session) {
  answer("{}", to_yaml(session.scenario, [](const fs::path& file) { return file.string(); }));
  answer("# {} x {}: {} beams x {} samples, {} rays a ping\n",
         counted(session.scenario.sequences, "sequence"),
         counted(session.ping_times_s.size(), "ping"), session.sonar.beam_count,
         session.record.samples, ping_size(session).rays);
  if (const auto& tiles = session.surface_tiles) {
    answer("# scatterers on surfaces: up to {} in the fan of a ping, in {} tiles\n",
           tiles->most_leaves, tiles->tiles.size());
  }
}

// Above this share of sequences that are sampled again, the kept worlds no longer follow the
// distributions of the scenario.
constexpr double kManyRedrawn = 0.05;

void warn_of_redraws(const PlacementTotals& placed) {
  if (static_cast<double>(placed.redrawn) <= kManyRedrawn * static_cast<double>(placed.sequences)) {
    return;
  }
  tell(
      "warning: {:.0f} % of the sequences find room only after they are sampled again, which "
      "favors few and small objects; a larger area_m or a smaller clearance_m gives more room, and "
      "place.on_failure: skip_object keeps the sequence without the object\n",
      100.0 * static_cast<double>(placed.redrawn) / static_cast<double>(placed.sequences));
}

// The sequences whose objects are printed: the first, and two more if each has a world of its own.
std::vector<std::uint32_t> looked_at(const SequenceWorlds& worlds) {
  const std::uint32_t first = worlds.first_sequence();
  if (!worlds.vary()) return {first};
  std::vector<std::uint32_t> sequences = {first};
  for (const std::uint32_t sequence : spread_order(0, worlds.first().scenario.sequences, 3)) {
    if (sequence != first && sequences.size() < 3) sequences.push_back(sequence);
  }
  return sequences;
}

// Prints a table of the objects of each of these sequences.
Status look_at_sequences(const SequenceWorlds& worlds, const Numerics& numerics,
                         const Workers& workers) {
  SeenObjects seen;
  for (const std::uint32_t sequence : looked_at(worlds)) {
    const Result<ReadyWorld> world = worlds.world(sequence);
    if (!world && world.error().kind == ErrorKind::usage) continue;  // reported by the census
    if (!world) return world.error();
    const auto& [session, tracer] = *world;
    const auto looks = look_at_objects(*session, *tracer, sequence, numerics, workers);
    if (!looks) continue;  // noise.snr_db without an echo, which generate refuses
    answer("# ping 0 of sequence {}:\n", sequence);
    for (const std::string& line : look_lines(*looks)) answer("#   {}\n", line);
    note_seen(*session, *tracer, sequence, *looks, workers, seen);
  }
  for (const std::string& text : unseen_warnings(seen, worlds.first().scenario)) {
    tell("warning: {}\n", text);
  }
  return {};
}

void announce_disk(const fs::path& output, double bytes) {
  answer("# disk: about {}\n", bytes_text(static_cast<std::uint64_t>(bytes)));
  const auto free = free_bytes(output);
  if (!free) return;
  answer("# free disk space in {}: {}{}\n", output.empty() ? "this folder" : output.string(),
         bytes_text(*free), bytes > static_cast<double>(*free) ? ", which is too little" : "");
}

// Prints files, disk space, free space, peak memory and time of a run of all sequences of the job,
// measured on a few of its pings. `start`: the time before the first ping. Error kinds: those of
// measure_pings.
Status announce_run(const CheckOptions& options, const Session& session, const Cost& cost,
                    std::uint64_t peak_bytes, const MeasureJob& job, const RunTime& start) {
  const std::string threads = counted(static_cast<std::uint64_t>(job.threads), "thread");
  const auto announce_memory = [&] {
    answer("# peak memory: about {} with {}\n", bytes_text(peak_bytes), threads);
  };
  answer("# files: {}\n", cost.files);
  if (const std::uint64_t available = available_memory(); peak_bytes > available) {
    announce_disk(options.output, static_cast<double>(cost.disk_bytes));
    announce_memory();
    answer("# pings measured for disk and time: 0, because only {} of memory is available\n",
           bytes_text(available));
    return {};
  }
  SharedParts first;
  const Result<Measured> measured = measure_pings(job, first);
  if (!measured) return measured.error();
  announce_disk(options.output, disk_bytes(*measured, session, all_of(job)));
  announce_memory();
  const RunTime time = start + time_of(*measured, job);
  answer("# time: about {} with {}, {} of one core\n", seconds_text(time.wall_s), threads,
         seconds_text(time.core_s));
  answer("# pings measured for disk and time: {} (sequences: {})\n", measured->pings,
         measured->sequences);
  return {};
}

Status unless_failed(const WorldCensus& census) {
  if (census.failed.empty()) return {};
  return Error{ErrorKind::incomplete, failures_text(census.failed, census.looked_at)};
}

}  // namespace

Status check(const CheckOptions& options) {
  const RunTime start = time_now();
  Result<SequenceWorlds> worlds = SequenceWorlds::open_untraced(options.input);
  if (!worlds) return worlds.error();
  const Session& session = worlds->first();
  const Workers workers(options.threads);
  for (const std::string& text : all_warnings(session, Tracer(session.world), workers)) {
    tell("warning: {}\n", text);
  }
  // Includes the processor time that loading the program took.
  const RunTime before_pings = time_now() - RunTime{start.wall_s, 0};
  const ResidentMemory loaded = resident_memory();
  const Result<Numerics> numerics = settled_numerics(options.backend, options.simd, false);
  if (!numerics) return numerics.error();
  const EchoCounts echoes = count_echoes(session);
  const Cost cost = estimate_cost(session, echoes.surface + echoes.coherent);
  const std::uint64_t peak =
      peak_bytes(session, workers.threads(), loaded, echoes, cpu_memory(session, *numerics));
  const Result<WorldCensus> census = take_census(
      *worlds, options.all_worlds ? session.scenario.sequences : kWorldsLookedAt, workers);
  if (!census) return census.error();
  answer_scenario(session);
  for (const std::string& line : census_lines(*census)) answer("# {}\n", line);
  warn_of_redraws(census->placement);
  worlds->trace_first();
  if (Status told = look_at_sequences(*worlds, *numerics, workers); !told) return told;
  MeasureJob job{{0, session.scenario.sequences},
                 {},
                 static_cast<std::uint32_t>(session.ping_times_s.size()),
                 worlds->vary(),
                 [&](std::uint32_t sequence) { return worlds->world(sequence); },
                 *numerics,
                 workers.threads()};
  job.first = worlds->first_sequence();
  job.disk = folder_there(options.output);
  job.most_pings = kMeasuredPerThread * static_cast<std::uint32_t>(job.threads);
  if (Status told = announce_run(options, session, cost, peak, job, before_pings); !told)
    return told;
  return unless_failed(*census);
}

}  // namespace ensonify
