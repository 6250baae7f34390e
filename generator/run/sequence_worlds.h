// The worlds of a run's sequences: one for all if nothing is sampled, otherwise a new one for each.
//
//   ReadyWorld      a session and the tracer of its world
//   ScenarioSource  returns the scenario of each sequence
//   BuiltWorld      a world that others may share
//   SequenceWorlds  open, open_in, info, unreadable, session, world, keep, begin_at
//   range_of        the requested pings of a sequence
//   of_sequence     an error with the number of its sequence
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "dataset/manifest.h"
#include "ping/prepare_session.h"
#include "ping/session.h"
#include "run/options.h"
#include "run/rig_worlds.h"
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
  // Whether an error of `scenario` may come from the values that one sequence samples.
  std::function<bool()> is_sampled;
};

struct BuiltWorld {
  std::shared_ptr<const World> world;
  std::shared_ptr<const Tracer> tracer;  // of this world
};

class SequenceWorlds {
 public:
  // Reads the scenario, checks its distributions and builds the first world: that of the first
  // sequence that can be made. An error that depends on samples (no room for objects, values that
  // contradict each other) belongs to its sequence. Errors of the scenario: those of load_scenario,
  // prepare_session and check_draws, if no sequence can be made, or kMostAlike fail in the same
  // words; with the place of the key in the file. `beyond`: sequences that the scenario does not
  // count may be asked for as well.
  static Result<SequenceWorlds> open(const ScenarioOptions& input, bool beyond = false);
  // The same without a tracer, which trace_first makes. Before a world is built, its scenario is
  // checked by `fits`, whose errors are returned with the place of the key. `rig`, unless null, has
  // the worlds that this instrument shares with others.
  using ScenarioCheck = std::function<Status(const Scenario&)>;
  static Result<SequenceWorlds> open_untraced(const ScenarioOptions& input, ScenarioCheck fits = {},
                                              bool beyond = false,
                                              std::shared_ptr<RigWorlds> rig = {});
  void trace_first();
  // An error about the first session with the place of its key.
  Error placed(const Error& error) const { return source_.placed(error); }
  // The same with the existing world of sequence 0, or with the error that building it returned.
  static Result<SequenceWorlds> open_in(ScenarioSource source, const Result<BuiltWorld>& built);

  // Whether each sequence has a world of its own.
  bool vary() const;
  // The first one that can be made.
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
  // The next call of `world` for this sequence returns this one instead of building it again.
  void keep(std::uint32_t sequence, ReadyWorld world) const;

  // Error (final_usage): a run that begins with this sequence ends there, as is known already.
  Status begin_at(std::uint32_t sequence) const;

 private:
  explicit SequenceWorlds(ScenarioSource source) : source_(std::move(source)) {}

  struct Facts;
  // drawn_session, with what earlier worlds have read and computed, unless `built` is the world.
  // Sets `facts`, unless null, as soon as a scenario has been read.
  Result<Session> drawn(std::uint32_t sequence, Facts* facts = nullptr,
                        const Result<BuiltWorld>* built = nullptr) const;
  // The error of a sequence for those who asked for it.
  Error told(std::uint32_t sequence, const Error& error, ErrorPlaces places) const;
  // Sets the first world, without its tracer, and what failed before it.
  Status find_first(bool beyond, const Result<BuiltWorld>* built = nullptr);

  ScenarioSource source_;
  ScenarioCheck fits_;  // only while it is opened
  std::shared_ptr<const Tracer> tracer_of(const Session& session, std::uint32_t sequence) const;

  std::unique_ptr<SharedWorlds> shared_ = std::make_unique<SharedWorlds>();
  std::shared_ptr<RigWorlds> rig_;  // null: no instruments share worlds
  std::uint32_t first_sequence_ = 0;
  ReadyWorld first_;
  struct Kept {
    std::mutex mutex;
    std::map<std::uint32_t, ReadyWorld> worlds;
  };
  std::unique_ptr<Kept> kept_ = std::make_unique<Kept>();
  std::vector<Error> failed_;  // of the sequences before the first one that can be made
};

// Among these the first one that can be made is sought; each may take kMostRedraws samples plus
// one. Of sequences that a scenario does not count, it is sought among fewer.
inline constexpr std::uint32_t kFirstTried = 256, kFirstTriedBeyond = 64;

// More would delay the first ping; errors of the other sequences are found when their turn comes.
inline constexpr std::uint32_t kSequencesChecked = 64;

// The requested pings of a sequence. Errors (usage): it has fewer.
Result<PingRange> range_of(const std::optional<PingRange>& asked, const Session& session);

Error of_sequence(std::uint32_t sequence, const Error& error);

}  // namespace ensonify
