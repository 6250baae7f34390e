#include "app/sequence_worlds.h"

#include <fmt/format.h>

#include <algorithm>

namespace ensonify {
namespace {

ReadyWorld ready(Session session) {
  ReadyWorld world;
  world.session = std::make_shared<const Session>(std::move(session));
  world.tracer = std::make_shared<const Tracer>(world.session->world);
  return world;
}

// The text is read once: an edit of the file meanwhile does not change this run.
ScenarioSource source_of(const ScenarioOptions& input, std::string text) {
  const auto shared =
      std::make_shared<const std::pair<ScenarioOptions, std::string>>(input, std::move(text));
  return {[shared](std::uint32_t sequence, ErrorPlaces places) {
            const auto& [options, yaml] = *shared;
            return parse_scenario(yaml, options.scenario.string(), options.scenario.parent_path(),
                                  options.overrides, sequence, {}, places);
          },
          [shared](const Error& error) {
            const auto& [options, yaml] = *shared;
            return with_place(error, yaml, options.scenario.string(), options.overrides);
          }};
}

}  // namespace

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

Result<SequenceWorlds> SequenceWorlds::open(const ScenarioOptions& input) {
  Result<std::string> text = read_scenario_text(input.scenario);
  if (!text) return text.error();
  SequenceWorlds worlds(source_of(input, *text));
  Result<Scenario> scenario = worlds.source_.scenario(0, ErrorPlaces::shown);
  if (!scenario) return scenario.error();
  if (scenario->has_draws) {
    const Status draws =
        check_draws(*text, input.scenario.string(), input.scenario.parent_path(), input.overrides);
    if (!draws) return draws.error();
  }
  Result<Session> session = prepare_session(std::move(*scenario), 0);
  if (!session) return worlds.source_.placed(session.error());
  worlds.first_ = ready(std::move(*session));
  return worlds;
}

Result<SequenceWorlds> SequenceWorlds::open_in(ScenarioSource source,
                                               const Result<BuiltWorld>& built) {
  SequenceWorlds worlds(std::move(source));
  Result<Scenario> scenario = worlds.source_.scenario(0, ErrorPlaces::shown);
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
    if (!range) return range.error();
    return sequence_info(session, sequence, range->first, range->second);
  };
  if (!vary() || sequence == 0) return of(first());
  Result<Scenario> scenario = source_.scenario(sequence, ErrorPlaces::shown);
  if (!scenario) return scenario.error();
  const Result<Session> session = prepare_without_world(std::move(*scenario), sequence);
  return session ? of(*session) : source_.placed(session.error());
}

Status SequenceWorlds::check_some(const std::optional<PingRange>& pings,
                                  const Workers& workers) const {
  if (!vary()) return {};
  const std::uint64_t all = first().scenario.sequences;
  const auto count = std::min<std::uint64_t>(all, kSequencesChecked);
  std::vector<Status> statuses(count);
  workers.for_each(count, [&](std::size_t i) {
    const auto sequence = static_cast<std::uint32_t>(i * all / count);
    const Result<SequenceInfo> read = info(sequence, pings);
    if (!read) statuses[i] = of_sequence(sequence, read.error());
  });
  for (Status& status : statuses) {
    if (!status) return std::move(status);
  }
  return {};
}

Result<ReadyWorld> SequenceWorlds::world(std::uint32_t sequence) const {
  if (!vary() || sequence == 0) return first_;
  Result<Scenario> scenario = source_.scenario(sequence, ErrorPlaces::hidden);
  if (!scenario) return scenario.error();
  Result<Session> session = prepare_session(std::move(*scenario), sequence);
  if (!session) return session.error();
  return ready(std::move(*session));
}

}  // namespace ensonify
