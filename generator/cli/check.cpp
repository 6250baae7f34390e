#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/commands.h"
#include "core/counted.h"
#include "ping/key_warnings.h"
#include "ping/object_looks.h"
#include "ping/scene_warnings.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "run/cost.h"
#include "run/disk_room.h"
#include "run/display_limits.h"
#include "run/make_dataset.h"
#include "run/measure.h"
#include "run/memory.h"
#include "run/memory_room.h"
#include "run/memory_there.h"
#include "run/rig.h"
#include "run/sequence_worlds.h"
#include "run/terminal.h"
#include "run/world_census.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

void answer_scenario(const Session& session) {
  answer("{}", to_yaml(session.scenario, [](const fs::path& file) { return file.string(); }));
  const std::string pings =
      fmt::format("# {} x {}", counted(session.scenario.sequences, "sequence"),
                  counted(session.ping_times_s.size(), "ping"));
  if (!is_sonar(session.scenario)) return answer("{}\n", pings);
  answer("{}: {} beams x {} samples, {} rays a ping\n", pings, session.sonar.beam_count,
         session.record.samples, ping_size(session).rays);
  if (const auto& tiles = session.surface_tiles) {
    answer("# scatterers on surfaces: up to {} in the fan of a ping, in {} tiles\n",
           most_surface_points(session), tiles->tiles.size());
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

// The same sequences as measure_pings would have, if there is no memory for it.
Result<std::vector<LookedSequence>> look_at_sequences(const MeasureJob& job) {
  std::vector<LookedSequence> looked;
  const auto look = [&](std::uint32_t sequence, const ReadyWorld& world) -> Status {
    auto objects = look_at_objects(*world.session, *world.tracer, sequence, job.numerics,
                                   Workers(job.threads));
    if (!objects) return objects.error();
    looked.push_back({sequence, world, std::move(*objects)});
    return {};
  };
  const Status done = for_probed_sequences(worlds_from_first(job.worlds), look);
  if (!done) return done.error();
  return looked;
}

// Prints a table of the objects of each of these sequences.
void answer_objects(const std::vector<LookedSequence>& looked, const Scenario& scenario,
                    const Workers& workers) {
  if (!is_sonar(scenario)) return;
  SeenObjects seen;
  for (const auto& [sequence, world, objects] : looked) {
    answer("# ping 0 of sequence {}:\n", sequence);
    for (const std::string& line : look_lines(objects)) answer("#   {}\n", line);
    note_seen(*world.session, *world.tracer, sequence, objects, workers, seen);
  }
  for (const std::string& text : unseen_warnings(seen, scenario)) tell("warning: {}\n", text);
}

void announce_disk(const fs::path& output, double bytes) {
  answer("# disk: about {}\n", bytes_text(static_cast<std::uint64_t>(bytes)));
  const auto free = free_bytes(output);
  if (!free) return;
  answer("# free disk space in {}: {}{}\n", output.empty() ? "this folder" : output.string(),
         bytes_text(*free), bytes > static_cast<double>(*free) ? ", which is too little" : "");
}

// Says from which pings the limits come if the scenario does not state them.
void announce_limits(const Measured& measured, const OutputSpec& output) {
  if (given_limits_db(output)) return;
  std::string sequences = "sequence";
  if (measured.looked.size() > 1) sequences += fmt::format("s {} and", measured.looked[0].sequence);
  sequences += fmt::format(" {}", measured.looked.back().sequence);
  answer("# limits of 8-bit images: {:g} to {:g} dB, from ping 0 of {}\n", measured.limits_db[0],
         measured.limits_db[1], sequences);
}

// What measure_pings has held at the same time.
RunMemory::Count measured_count(const Measured& measured, int threads) {
  const auto lanes = std::min(static_cast<std::uint64_t>(threads), measured.pings);
  return {.sequences = measured.sequences,
          .worlds = measured.sequences - 1,
          .computing = lanes,
          .scratches = lanes,
          .workers = static_cast<std::uint64_t>(threads)};
}

// Prints objects, files, disk space, free space, peak memory and time of a run of all sequences,
// measured on its first pings. `start`: the time before the first ping. Error kinds: those of
// measure_pings.
Status announce_run(const CheckOptions& options, const Cost& cost, const RunMemory& memory,
                    const MeasureJob& job, const RunTime& start) {
  const Session& session = job.worlds.first();
  const std::string threads = counted(static_cast<std::uint64_t>(job.threads), "thread");
  const auto announce_size = [&](double disk_bytes, std::uint64_t peak) {
    answer("# files: {}\n", cost.files);
    announce_disk(options.output, disk_bytes);
    answer("# peak memory: about {} with {}\n", bytes_text(peak), threads);
  };
  if (const std::uint64_t available = memory_there().bytes; added_bytes(memory) > available) {
    const auto looked = look_at_sequences(job);
    if (!looked) return looked.error();
    answer_objects(*looked, session.scenario, Workers(job.threads));
    announce_size(static_cast<double>(cost.disk_bytes), peak_bytes(memory));
    answer("# pings measured for disk and time: 0, because only {} of memory is available\n",
           bytes_text(available));
    return {};
  }
  const Result<Measured> measured = measure_pings(job);
  if (!measured) return measured.error();
  answer_objects(measured->looked, session.scenario, Workers(job.threads));
  announce_limits(*measured, session.scenario.output);
  announce_size(disk_bytes(*measured, session),
                peak_bytes(memory, measured_count(*measured, job.threads), resident_memory()));
  const RunTime time = start + time_of(*measured, session.scenario.sequences,
                                       static_cast<std::uint32_t>(session.ping_times_s.size()),
                                       job.worlds.vary(), job.threads);
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

Status check_one(const CheckOptions& options) {
  const RunTime start = time_now();
  Result<SequenceWorlds> worlds = SequenceWorlds::open_untraced(options.input, room_for_scenario);
  if (!worlds) return worlds.error();
  const Session& session = worlds->first();
  if (Status room = room_for_world(session); !room) return worlds->placed(room.error());
  worlds->trace_first();
  const ResidentMemory loaded = resident_memory();
  const auto warn = [](std::string_view text) { tell("warning: {}\n", text); };
  Result<Numerics> numerics = settled_numerics(options.backend, options.simd, false);
  if (!numerics) return numerics.error();
  numerics = numerics_that_fit(session, worlds->first_tracer(), *numerics, warn);
  if (!numerics) return worlds->placed(numerics.error());
  const Result<int> threads = threads_that_fit(session, worlds->first_tracer(), *numerics,
                                               Workers(options.threads).threads(), warn);
  if (!threads) return worlds->placed(threads.error());
  const Workers workers(*threads);
  std::vector<std::string> warnings = all_warnings(session, worlds->first_tracer(), workers);
  if (is_sonar(session.scenario)) {
    for (auto& text : fan_warnings(session, worlds->first_tracer(), workers)) {
      warnings.push_back(std::move(text));
    }
  }
  for (const std::string& text : warnings) tell("warning: {}\n", text);
  const SynthesisMemory synthesis = cpu_memory(session, *numerics);
  // Includes the processor time that loading the program took.
  const RunTime before_pings = time_now() - RunTime{start.wall_s, 0};
  const EchoCounts echoes = count_echoes(session, worlds->first_tracer());
  const Cost cost = estimate_cost(session, echoes.surface + echoes.coherent);
  const RunMemory memory = run_memory(session, workers.threads(), loaded, echoes, synthesis);
  const Result<WorldCensus> census = take_census(
      *worlds, options.all_worlds ? session.scenario.sequences : kWorldsLookedAt, workers);
  if (!census) return census.error();
  answer_scenario(session);
  for (const std::string& line : census_lines(*census)) answer("# {}\n", line);
  warn_of_redraws(census->placement);
  const MeasureJob job{*worlds, *numerics, workers.threads(), folder_there(options.output)};
  if (Status told = announce_run(options, cost, memory, job, before_pings); !told) return told;
  return unless_failed(*census);
}

}  // namespace

Status check(const CheckOptions& options) {
  CheckOptions one = options;
  const Result<Instruments> names = instruments_of(one.input);
  if (!names) return names.error();
  if (names->empty()) return check_one(one);
  const ScenarioOptions input = one.input;
  Status failed;
  for (const std::string& name : *names) {
    one.input = with_instrument(input, name);
    answer("# instrument {}:\n", name);
    const Status status = check_one(one);
    if (!status && status.error().kind != ErrorKind::incomplete) {
      return of_instrument(name, status.error(), input.scenario);
    }
    if (!status && failed) failed = of_instrument(name, status.error(), input.scenario);
  }
  return failed;
}

}  // namespace ensonify
