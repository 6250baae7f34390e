#include "run/sequence_worlds.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/counted.h"
#include "ping/prepare_session.h"
#include "ping/sequence_info.h"
#include "scenario/draw.h"

namespace ensonify {
namespace {

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
          },
          [shared] { return is_sampled(shared->second, shared->first.overrides); }};
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

// What is known of a scenario once it has been read for any sequence.
struct SequenceWorlds::Facts {
  std::uint32_t sequences = 0;  // 0: it has not been read
  bool vary = false;
};

Result<Session> SequenceWorlds::drawn(std::uint32_t sequence, Facts* facts,
                                      const Result<BuiltWorld>* built) const {
  return drawn_session({[&](SequenceDraw draw) {
                          Result<Scenario> scenario = source_.scenario(draw, ErrorPlaces::hidden);
                          if (scenario && facts != nullptr) {
                            *facts = {scenario->sequences, varies_by_sequence(*scenario)};
                          }
                          return scenario;
                        },
                        [&](Scenario scenario, std::uint32_t of) -> Result<Session> {
                          if (const Status fits = fits_ ? fits_(scenario) : Status(); !fits)
                            return fits.error();
                          if (rig_) return rig_->session(std::move(scenario), of);
                          if (built == nullptr)
                            return prepare_session(std::move(scenario), of, shared_.get());
                          return prepare_in_world(std::move(scenario), of,
                                                  *built ? Result<World>(*(*built)->world)
                                                         : Result<World>(built->error()));
                        }},
                       sequence);
}

Error SequenceWorlds::told(std::uint32_t sequence, const Error& error, ErrorPlaces places) const {
  if (places == ErrorPlaces::hidden) return as_usage(error);
  const Result<Scenario> scenario = source_.scenario(sequence, ErrorPlaces::shown);
  return scenario ? source_.placed(as_usage(error)) : scenario.error();
}

Status SequenceWorlds::find_first(bool beyond, const Result<BuiltWorld>* built) {
  Facts facts;
  bool alike = true;
  std::uint32_t end = kFirstTried;
  for (std::uint32_t sequence = 0; sequence < end; ++sequence) {
    Result<Session> session = drawn(sequence, &facts, sequence == 0 ? built : nullptr);
    if (session && !beyond && sequence >= facts.sequences) break;
    if (session) {
      first_sequence_ = sequence;
      first_.session = std::make_shared<const Session>(std::move(*session));
      return {};
    }
    const Error& error = session.error();
    if (error.kind != ErrorKind::usage && !is_of_sequence(error)) {
      return told(sequence, error, ErrorPlaces::shown);
    }
    failed_.push_back(error);
    const bool may_differ = facts.sequences > 0 ? facts.vary : sequence > 0 || source_.is_sampled();
    alike = alike && !is_of_sequence(error) && error.message == failed_[0].message;
    if (!may_differ || (alike && failed_.size() == kMostAlike)) break;
    if (facts.sequences == 0) continue;
    const std::uint32_t most = beyond ? kFirstTriedBeyond : 1;
    end = std::min(kFirstTried, std::max(facts.sequences, most));
  }
  Error error = told(0, failed_[0], ErrorPlaces::shown);
  error.kind = ErrorKind::usage;
  if (!alike && failed_.size() > 1) {
    error.message +=
        fmt::format("\nnone of the first {} can be made", counted(failed_.size(), "sequence"));
  }
  return error;
}

Result<SequenceWorlds> SequenceWorlds::open(const ScenarioOptions& input, bool beyond) {
  Result<SequenceWorlds> worlds = open_untraced(input, {}, beyond);
  if (worlds) worlds->trace_first();
  return worlds;
}

void SequenceWorlds::trace_first() { first_.tracer = tracer_of(*first_.session, first_sequence_); }

std::shared_ptr<const Tracer> SequenceWorlds::tracer_of(const Session& session,
                                                        std::uint32_t sequence) const {
  if (rig_) return rig_->tracer(session, sequence);
  return std::make_shared<const Tracer>(session.world);
}

Result<SequenceWorlds> SequenceWorlds::open_untraced(const ScenarioOptions& input,
                                                     ScenarioCheck fits, bool beyond,
                                                     std::shared_ptr<RigWorlds> rig) {
  Result<std::string> text =
      input.text ? Result<std::string>(*input.text) : read_scenario_text(input.scenario);
  if (!text) return text.error();
  SequenceWorlds worlds(source_of(input, *text));
  worlds.fits_ = std::move(fits);
  worlds.rig_ = std::move(rig);
  if (Status found = worlds.find_first(beyond); !found) return found.error();
  if (worlds.first().scenario.has_draws) {
    const Status draws =
        check_draws(*text, input.scenario.string(), input.scenario.parent_path(), input.overrides);
    if (!draws) return draws.error();
  }
  worlds.fits_ = {};
  return worlds;
}

Result<SequenceWorlds> SequenceWorlds::open_in(ScenarioSource source,
                                               const Result<BuiltWorld>& built) {
  SequenceWorlds worlds(std::move(source));
  const bool has_world = built || built.error().kind != ErrorKind::redraw;
  if (Status found = worlds.find_first(false, has_world ? &built : nullptr); !found) {
    return found.error();
  }
  if (has_world && worlds.first_sequence_ == 0) {
    worlds.first_.tracer = built->tracer;
  } else {
    worlds.trace_first();
  }
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
  if (sequence < failed_.size()) return told(sequence, failed_[sequence], places);
  Result<Session> session = drawn(sequence);
  return session ? std::move(session) : told(sequence, session.error(), places);
}

Result<ReadyWorld> SequenceWorlds::world(std::uint32_t sequence) const {
  if (!vary() || sequence == first_sequence_) return first_;
  {
    const std::lock_guard lock(kept_->mutex);
    if (auto kept = kept_->worlds.extract(sequence)) return std::move(kept.mapped());
  }
  Result<Session> session = this->session(sequence, ErrorPlaces::hidden);
  if (!session) return session.error();
  ReadyWorld world;
  world.session = std::make_shared<const Session>(std::move(*session));
  world.tracer = tracer_of(*world.session, sequence);
  return world;
}

void SequenceWorlds::keep(std::uint32_t sequence, ReadyWorld world) const {
  if (!vary() || sequence == first_sequence_) return;
  const std::lock_guard lock(kept_->mutex);
  kept_->worlds.insert_or_assign(sequence, std::move(world));
}

Status SequenceWorlds::begin_at(std::uint32_t sequence) const {
  if (sequence >= failed_.size() || failed_[sequence].kind != ErrorKind::final_usage) return {};
  return of_sequence(sequence, told(sequence, failed_[sequence], ErrorPlaces::shown));
}

}  // namespace ensonify
