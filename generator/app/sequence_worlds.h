// The worlds of a run's sequences: one for all where nothing is drawn, a new one for each where
// something is.
//
//   ReadyWorld      a session and the tracer of its world
//   ScenarioSource  where the scenario of each sequence comes from
//   BuiltWorld      a world that others may share
//   SequenceWorlds  open, open_in, info, all_infos, world
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
  std::function<Result<Scenario>(std::uint32_t)> scenario;
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
  // Reads the scenario and builds the world of sequence 0. Errors: those of load_scenario and
  // prepare_session, the latter with the place of the key in the file.
  static Result<SequenceWorlds> open(const ScenarioOptions& input);
  // The same in the world of sequence 0, or the error of building it, that is there already.
  static Result<SequenceWorlds> open_in(ScenarioSource source, const Result<BuiltWorld>& built);

  // Whether each sequence has a world of its own.
  bool vary() const;
  const Session& first() const { return *first_.session; }
  const Tracer& first_tracer() const { return *first_.tracer; }

  // What the files of a sequence say of it, as far as it is known without building its world: ids,
  // names and classes of the instances, but nothing measured on them. `pings` absent: all that the
  // sequence has. Errors (usage): its draws do not make a valid scenario, or it has fewer pings.
  // May be called from several threads at once.
  Result<SequenceInfo> info(std::uint32_t sequence, const std::optional<PingRange>& pings) const;

  // The same for all sequences. The error is that of the first that has one.
  Result<std::vector<SequenceInfo>> all_infos(const std::optional<PingRange>& pings,
                                              const Workers& workers) const;

  // Errors (usage): its world cannot be built. May be called from several threads at once.
  Result<ReadyWorld> world(std::uint32_t sequence) const;

 private:
  explicit SequenceWorlds(ScenarioSource source) : source_(std::move(source)) {}

  ScenarioSource source_;
  ReadyWorld first_;
};

}  // namespace ensonify
