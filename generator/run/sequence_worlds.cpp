#include "ping/prepare_session.h"
#include "ping/sequence_info.h"
#include "run/sequence_worlds.h"

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

// The text is read once, so that editing the file meanwhile does not change this run.
ScenarioSource source_of(const ScenarioOptions& input, std::string text) {
  const auto shared =
      std::make_shared<const std::pair<ScenarioOptions, std::string>>(input, std::move(text));
  return {[shared](SequenceDraw draw, ErrorPlaces places) {
            const auto& [options, yaml] = *shared;
            return parse_scenario(yaml, options.scenario.string(), options.scenario.parent_path(),
                                  options.overrides, draw, {}, places);
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
  return Error{
      ErrorKind::usage,
      fmt::format(
          "--pings {}:{}: the scenario has pings 0 to {}; expected A:B with 0 <= A < B <= {}",
          first, last, total - 1, total)};
}

Result<Session> SequenceWorlds::drawn(std::uint32_t sequence, ErrorPlaces places) const {
  return drawn_session({[&](SequenceDraw draw) { return source_.scenario(draw, places); },
                        [&](Scenario scenario, std::uint32_t of) {
                          Result<Session> session =
                              prepare_session(std::move(scenario), of, shared_.get());
                          const bool is_told = session || places == ErrorPlaces::hidden;
                          return is_told ? std::move(session) : source_.placed(session.error());
                        }},
                       sequence);
}

Result<SequenceWorlds> SequenceWorlds::open(const ScenarioOptions& input) {
  Result<SequenceWorlds> worlds = open_untraced(input);
  if (worlds) worlds->trace_first();
  return worlds;
}

void SequenceWorlds::trace_first() {
  first_.tracer = std::make_shared<const Tracer>(first_.session->world);
}

Result<SequenceWorlds> SequenceWorlds::open_untraced(const ScenarioOptions& input) {
  Result<std::string> text =
      input.text ? Result<std::string>(*input.text) : read_scenario_text(input.scenario);
  if (!text) return text.error();
  SequenceWorlds worlds(source_of(input, *text));
  Result<Session> first = worlds.drawn(0, ErrorPlaces::shown);
  std::optional<Error> trouble;
  if (!first) trouble = first.error();
  for (std::uint32_t sequence = 1; trouble && sequence < kFirstTried; ++sequence) {
    if (trouble->kind != ErrorKind::usage) return *trouble;
    first = worlds.drawn(sequence, ErrorPlaces::shown);
    // The text of the scenario may be equal even if the sampled values differ.
    if (!first && first.error().message == trouble->message) return *trouble;
    if (!first) continue;
    if (!varies_by_sequence(first->scenario) || sequence >= first->scenario.sequences) break;
    worlds.first_sequence_ = sequence;
    trouble.reset();
  }
  if (trouble) return *trouble;
  if (first->scenario.has_draws) {
    const Status draws =
        check_draws(*text, input.scenario.string(), input.scenario.parent_path(), input.overrides);
    if (!draws) return draws.error();
  }
  worlds.first_.session = std::make_shared<const Session>(std::move(*first));
  return worlds;
}

Result<SequenceWorlds> SequenceWorlds::open_in(ScenarioSource source,
                                               const Result<BuiltWorld>& built) {
  SequenceWorlds worlds(std::move(source));
  if (!built && built.error().kind == ErrorKind::redraw) {
    Result<Session> session = worlds.drawn(0, ErrorPlaces::shown);
    if (!session) return session.error();
    worlds.first_ = ready(std::move(*session));
    return worlds;
  }
  Result<Session> session = drawn_session(
      {[&](SequenceDraw draw) { return worlds.source_.scenario(draw, ErrorPlaces::shown); },
       [&](Scenario scenario, std::uint32_t of) {
         return prepare_in_world(std::move(scenario), of,
                                 built ? Result<World>(*built->world)
                                       : Result<World>(built.error()));
       }},
      0);
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
  if (!vary() || sequence == first_sequence_) return of(first());
  Result<Scenario> scenario = source_.scenario(sequence, ErrorPlaces::shown);
  if (!scenario) return scenario.error();
  const Result<Session> session = prepare_without_world(std::move(*scenario), sequence);
  return session ? of(*session) : source_.placed(session.error());
}

std::vector<SequenceFailure> SequenceWorlds::unreadable(const std::optional<PingRange>& pings,
                                                        const Workers& workers) const {
  if (!vary()) return {};
  const std::uint64_t all = first().scenario.sequences;
  const auto count = std::min<std::uint64_t>(all, kSequencesChecked);
  std::vector<SequenceFailure> looks(count);
  workers.for_each(count, [&](std::size_t i) {
    looks[i].sequence = static_cast<std::uint32_t>(i * all / count);
    const Result<SequenceInfo> read = info(looks[i].sequence, pings);
    if (!read) looks[i].error = read.error().message;
  });
  std::erase_if(looks, [](const SequenceFailure& look) { return look.error.empty(); });
  return looks;
}

Result<Session> SequenceWorlds::session(std::uint32_t sequence, ErrorPlaces places) const {
  if (!vary() || sequence == first_sequence_) return first();
  return drawn(sequence, places);
}

Result<ReadyWorld> SequenceWorlds::world(std::uint32_t sequence) const {
  if (!vary() || sequence == first_sequence_) return first_;
  Result<Session> session = drawn(sequence, ErrorPlaces::hidden);
  if (!session) return session.error();
  return ready(std::move(*session));
}

}  // namespace ensonify
