#include "app/sequence_worlds.h"

#include <fmt/format.h>

namespace ensonify {
namespace {

ReadyWorld ready(Session session) {
  ReadyWorld world;
  world.session = std::make_shared<const Session>(std::move(session));
  world.tracer = std::make_shared<const Tracer>(world.session->world);
  return world;
}

// The text is read once: whoever edits the file meanwhile does not change this run.
ScenarioSource source_of(const ScenarioOptions& input, std::string text) {
  const auto shared =
      std::make_shared<const std::pair<ScenarioOptions, std::string>>(input, std::move(text));
  return {[shared](std::uint32_t sequence) {
            const auto& [options, yaml] = *shared;
            return parse_scenario(yaml, options.scenario.string(), options.scenario.parent_path(),
                                  options.overrides, sequence);
          },
          [shared](const Error& error) {
            const auto& [options, yaml] = *shared;
            return with_place(error, yaml, options.scenario.string(), options.overrides);
          }};
}

Error of_sequence(std::uint32_t sequence, const Error& error) {
  return {error.kind, fmt::format("sequence {}: {}", sequence, error.message)};
}

Result<PingRange> range_of(const std::optional<PingRange>& asked, const Session& session) {
  const auto total = static_cast<std::uint32_t>(session.ping_times_s.size());
  if (!asked) return PingRange{0, total};
  const auto [first, last] = *asked;
  if (first < last && last <= total) return *asked;
  return Error{ErrorKind::usage, fmt::format("--pings {}:{}: the scenario has pings 0 to {}; "
                                             "accepted is A:B with 0 <= A < B <= {}",
                                             first, last, total - 1, total)};
}

}  // namespace

Result<SequenceWorlds> SequenceWorlds::open(const ScenarioOptions& input) {
  Result<std::string> text = read_scenario_text(input.scenario);
  if (!text) return text.error();
  SequenceWorlds worlds(source_of(input, std::move(*text)));
  Result<Scenario> scenario = worlds.source_.scenario(0);
  if (!scenario) return scenario.error();
  Result<Session> session = prepare_session(std::move(*scenario), 0);
  if (!session) return worlds.source_.placed(session.error());
  worlds.first_ = ready(std::move(*session));
  return worlds;
}

Result<SequenceWorlds> SequenceWorlds::open_in(ScenarioSource source,
                                               const Result<BuiltWorld>& built) {
  SequenceWorlds worlds(std::move(source));
  Result<Scenario> scenario = worlds.source_.scenario(0);
  if (!scenario) return scenario.error();
  Result<Session> session = prepare_in_world(
      std::move(*scenario), 0, built ? Result<World>(*built->world) : Result<World>(built.error()));
  if (!session) return worlds.source_.placed(session.error());
  worlds.first_ = {std::make_shared<const Session>(std::move(*session)), built->tracer};
  return worlds;
}

bool SequenceWorlds::vary() const { return varies_by_sequence(first().scenario); }

Result<SequenceInfo> SequenceWorlds::info(std::uint32_t sequence,
                                          const std::optional<PingRange>& pings) const {
  const auto of = [&](const Session& session) -> Result<SequenceInfo> {
    const Result<PingRange> range = range_of(pings, session);
    if (!range) return vary() ? of_sequence(sequence, range.error()) : range.error();
    return sequence_info(session, sequence, range->first, range->second);
  };
  if (!vary() || sequence == 0) return of(first());
  Result<Scenario> scenario = source_.scenario(sequence);
  if (!scenario) return of_sequence(sequence, scenario.error());
  const Result<Session> session = prepare_without_world(std::move(*scenario), sequence);
  return session ? of(*session) : of_sequence(sequence, source_.placed(session.error()));
}

Result<std::vector<SequenceInfo>> SequenceWorlds::all_infos(const std::optional<PingRange>& pings,
                                                            const Workers& workers) const {
  const std::uint32_t count = first().scenario.sequences;
  std::vector<SequenceInfo> infos(count);
  std::vector<Status> statuses(count);
  workers.for_each(count, [&](std::size_t s) {
    Result<SequenceInfo> info = this->info(static_cast<std::uint32_t>(s), pings);
    if (info) {
      infos[s] = std::move(*info);
    } else {
      statuses[s] = info.error();
    }
  });
  for (const Status& status : statuses) {
    if (!status) return status.error();
  }
  return infos;
}

Result<ReadyWorld> SequenceWorlds::world(std::uint32_t sequence) const {
  if (!vary() || sequence == 0) return first_;
  Result<Scenario> scenario = source_.scenario(sequence);
  if (!scenario) return of_sequence(sequence, scenario.error());
  Result<Session> session = prepare_session(std::move(*scenario), sequence);
  if (!session) return of_sequence(sequence, source_.placed(session.error()));
  return ready(std::move(*session));
}

}  // namespace ensonify
