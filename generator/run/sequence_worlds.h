// The worlds of a run's sequences: one for all if nothing is sampled, otherwise a new one for each.
//
//   ReadyWorld      a session and the tracer of its world
//   ScenarioSource  returns the scenario of each sequence
//   BuiltWorld      a world that others may share
//   SequenceWorlds  open, open_in, info, unreadable, session, world
//   range_of        the requested pings of a sequence
//   of_sequence     an error with the number of its sequence
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "dataset/manifest.h"
#include "ping/prepare_session.h"
#include "ping/session.h"
#include "run/options.h"
#include "trace/tracer.h"

namespace ensonify {

struct ReadyWorld {
  std::shared_ptr<const Session> session;
  std::shared_ptr<const Tracer> tracer;
};

// Both may be called from several threads at once.
struct ScenarioSource {
  // As sampled. Errors (usage).
  std::function<Result<Scenario>(SequenceDraw, ErrorPlaces)> scenario;
  // An error of prepare_session with the place of its key.
  std::function<Error(const Error&)> placed;
};

struct BuiltWorld {
  std::shared_ptr<const World> world;
  std::shared_ptr<const Tracer> tracer;  // of this world
};

class SequenceWorlds {
 public:
  // Reads the scenario, checks its distributions and builds the first world: that of sequence 0, or
  // of the next of the first kFirstTried sequences that can be built. Errors: for sequence 0, those
  // of load_scenario or drawn_session, the latter with the place of the key in the file; those of
  // check_draws.
  static Result<SequenceWorlds> open(const ScenarioOptions& input);
  // The same without a tracer, which trace_first makes.
  static Result<SequenceWorlds> open_untraced(const ScenarioOptions& input);
  void trace_first();
  // The same with the existing world of sequence 0, or with the error that building it returned.
  static Result<SequenceWorlds> open_in(ScenarioSource source, const Result<BuiltWorld>& built);

  // Whether each sequence has a world of its own.
  bool vary() const;
  std::uint32_t first_sequence() const { return first_sequence_; }
  const Session& first() const { return *first_.session; }
  const Tracer& first_tracer() const { return *first_.tracer; }

  // Information for the files of a sequence that is known without its world: ids, names and classes
  // of the instances of its first sample, but no measures. Without `pings`, it is for all pings of
  // the sequence. Errors (usage), with places: its samples are not a valid scenario, or it has
  // fewer pings. May be called from several threads at once.
  Result<SequenceInfo> info(std::uint32_t sequence, const std::optional<PingRange>& pings) const;

  // Examines up to kSequencesChecked evenly spaced sequences and returns those for which info
  // fails.
  std::vector<SequenceFailure> unreadable(const std::optional<PingRange>& pings,
                                          const Workers& workers) const;

  // Errors (usage, final_usage): the samples of the sequence are not a valid scenario, or its world
  // cannot be built. The function `world` returns the same errors, without places. May be called
  // from several threads at once.
  Result<Session> session(std::uint32_t sequence, ErrorPlaces places) const;
  Result<ReadyWorld> world(std::uint32_t sequence) const;

 private:
  explicit SequenceWorlds(ScenarioSource source) : source_(std::move(source)) {}

  // prepare_session for drawn_session, with what earlier worlds have read and computed.
  Result<Session> drawn(std::uint32_t sequence, ErrorPlaces places) const;

  ScenarioSource source_;
  std::unique_ptr<SharedWorlds> shared_ = std::make_unique<SharedWorlds>();
  std::uint32_t first_sequence_ = 0;
  ReadyWorld first_;
};

// Each may take kMostRedraws samples plus one.
inline constexpr std::uint32_t kFirstTried = 8;

// More would delay the first ping; errors of the other sequences are found when their turn comes.
inline constexpr std::uint32_t kSequencesChecked = 64;

// The requested pings of a sequence. Errors (usage): it has fewer.
Result<PingRange> range_of(const std::optional<PingRange>& asked, const Session& session);

Error of_sequence(std::uint32_t sequence, const Error& error);

}  // namespace ensonify
