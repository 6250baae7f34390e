// The worlds of a run's sequences: one for all where nothing is drawn, a new one for each where
// something is.
//
//   ReadyWorld      a session and the tracer of its world
//   ScenarioSource  where the scenario of each sequence comes from
//   BuiltWorld      a world that others may share
//   SequenceWorlds  open, open_in, info, check_some, world
//   range_of        the pings of a sequence that are asked for
//   of_sequence     an error with the number of its sequence
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/commands.h"
#include "app/session.h"
#include "core/parallel.h"
#include "trace/tracer.h"

namespace ensonify {

struct ReadyWorld {
  std::shared_ptr<const Session> session;
  std::shared_ptr<const Tracer> tracer;
};

// Both may be called from several threads at once.
struct ScenarioSource {
  // As drawn for the sequence. Errors (usage).
  std::function<Result<Scenario>(std::uint32_t, ErrorPlaces)> scenario;
  // An error of prepare_session, with the place of its key.
  std::function<Error(const Error&)> placed;
};

struct BuiltWorld {
  std::shared_ptr<const World> world;
  std::shared_ptr<const Tracer> tracer;  // of this world
};

using PingRange = std::pair<std::uint32_t, std::uint32_t>;  // [first, last)

class SequenceWorlds {
 public:
  // Reads the scenario, checks its distributions and builds the world of sequence 0. Errors: those
  // of load_scenario, check_draws and prepare_session, the last with the place of the key in the
  // file.
  static Result<SequenceWorlds> open(const ScenarioOptions& input);
  // The same in the world of sequence 0, or the error of building it, that is there already.
  static Result<SequenceWorlds> open_in(ScenarioSource source, const Result<BuiltWorld>& built);

  // Whether each sequence has a world of its own.
  bool vary() const;
  const Session& first() const { return *first_.session; }
  const Tracer& first_tracer() const { return *first_.tracer; }

  // What the files of a sequence say of it, as far as it is known without building its world: ids,
  // names and classes of the instances, but nothing measured on them. `pings` absent: all that the
  // sequence has. Errors (usage), with places: its draws do not make a valid scenario, or it has
  // fewer pings. May be called from several threads at once.
  Result<SequenceInfo> info(std::uint32_t sequence, const std::optional<PingRange>& pings) const;

  // Looks at up to kSequencesChecked sequences, evenly spread. The error is that of the first that
  // has one, with its number.
  Status check_some(const std::optional<PingRange>& pings, const Workers& workers) const;

  // Errors (usage), without places: its draws do not make a valid scenario, or its world cannot be
  // built. May be called from several threads at once.
  Result<ReadyWorld> world(std::uint32_t sequence) const;

 private:
  explicit SequenceWorlds(ScenarioSource source) : source_(std::move(source)) {}

  ScenarioSource source_;
  ReadyWorld first_;
};

// More would keep the first ping waiting; what the others have is found when their turn comes.
inline constexpr std::uint32_t kSequencesChecked = 64;

// The pings of a sequence that are to be made. Errors (usage): it has fewer.
Result<PingRange> range_of(const std::optional<PingRange>& asked, const Session& session);

Error of_sequence(std::uint32_t sequence, const Error& error);

}  // namespace ensonify
