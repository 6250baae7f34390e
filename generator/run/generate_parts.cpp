#include "run/generate_parts.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

#include "run/memory_room.h"
#include "run/terminal.h"

namespace ensonify {

void warn(const GenerateOptions& options, std::string_view text) {
  if (options.hooks != nullptr) {
    options.hooks->warn(text);
  } else {
    tell("warning: {}\n", text);
  }
}

namespace {

// The requested pings, those of a rig by time.
Result<std::optional<PingRange>> pings_of(const GenerateOptions& options, const Session& session) {
  if (!options.pings || session.scenario.rig.empty()) return options.pings;
  const Result<PingRange> range = pings_in_time(*options.pings, session);
  if (!range) return range.error();
  return std::optional(*range);
}

Result<Opened> open_dataset(const GenerateOptions& options, Pings pings,
                            const std::shared_ptr<RigWorlds>& rig,
                            const std::shared_ptr<TableCache>& tables) {
  const bool checks = pings == Pings::wanted;
  Result<SequenceWorlds> worlds = SequenceWorlds::open_untraced(
      options.input, checks ? room_for_scenario : SequenceWorlds::ScenarioCheck(), false, rig);
  if (!worlds) return worlds.error();
  const Status room = checks ? room_for_world(worlds->first()) : Status();
  if (!room) return worlds->placed(room.error());
  worlds->trace_first();
  Result<Numerics> numerics = settled_numerics(options.backend, options.simd, options.quiet);
  if (!numerics) return numerics.error();
  if (rig) numerics->tables = tables;  // equal sonars have the same
  const auto warns = [&](std::string_view text) { warn(options, text); };
  numerics = numerics_that_fit(worlds->first(), worlds->first_tracer(), *numerics, warns);
  if (!numerics) return worlds->placed(numerics.error());
  Result<int> threads = Workers(options.threads).threads();
  if (checks) {
    threads = threads_that_fit(worlds->first(), worlds->first_tracer(), *numerics, *threads, warns);
  }
  if (!threads) return worlds->placed(threads.error());
  const auto range = pings_of(options, worlds->first());
  if (!range) return range.error();
  FileHashes hashes;
  Result<DatasetWork> work = settle_dataset(*worlds, *range, options.sequences, *numerics, hashes);
  if (!work) return work.error();
  return Opened{options, std::move(*worlds), std::move(*numerics), std::move(*work), *threads};
}

// The options of each part.
std::vector<GenerateOptions> options_of_parts(const GenerateOptions& options,
                                              const Instruments& names) {
  if (names.empty()) return {options};
  std::vector<GenerateOptions> list;
  for (const std::string& name : names) {
    list.push_back(options);
    list.back().input = with_instrument(options.input, name);
    list.back().output = options.output / name;
    list.back().quiet = options.quiet || list.size() > 1;  // the backend is announced once
  }
  return list;
}

}  // namespace

Error of_part(const Parts& parts, std::size_t part, const Error& error,
              const std::filesystem::path& scenario) {
  return parts.names.empty() ? error : of_instrument(parts.names[part], error, scenario);
}

Result<Parts> open_parts(GenerateOptions options, Pings pings) {
  const Result<Instruments> names = instruments_of(options.input);
  if (!names) return names.error();
  Parts parts{{}, *names};
  const auto rig = names->empty() ? nullptr : std::make_shared<RigWorlds>();
  const auto tables = std::make_shared<TableCache>(std::max<std::size_t>(2, names->size()));
  for (const GenerateOptions& part : options_of_parts(options, *names)) {
    Result<Opened> opened = open_dataset(part, pings, rig, tables);
    if (!opened) return of_part(parts, parts.list.size(), opened.error(), part.input.scenario);
    opened->options.quiet = options.quiet;
    parts.list.push_back(std::move(*opened));
  }
  return parts;
}

}  // namespace ensonify
