// A scenario and its worlds, as the module `_core` stores them.
//
//   claim_process    before anything is built
//   CheckedScenario  builds its first world on demand
//   LaneRequest  StreamRequest  stream_of
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "run/live_sequence.h"
#include "run/ping_stream.h"

namespace ensonify::python {

// Worlds use threads, some of them of the ray tracing library, which a fork does not copy. Only the
// first process of a family that builds a world may build worlds. Error (device): this is another
// process.
Status claim_process();

class CheckedScenario {
 public:
  // Errors: those of parse_scenario and check_draws. Starts no threads.
  static Result<std::shared_ptr<CheckedScenario>> open(ScenarioOptions input,
                                                       BackendChoice backend);

  const ScenarioOptions& input() const { return input_; }
  // As sampled for the first sequence whose sampled values agree.
  const Scenario& first() const { return first_; }

  // The text of the scenario as sampled for the sequence, without distributions. Errors: those of
  // source and SequenceWorlds::session.
  Result<std::string> sample(std::uint32_t sequence);

  // The warnings of the first call of `source`, once.
  std::vector<std::string> new_warnings();

  // Callable from any thread. Errors: those of open_source and claim_process.
  Result<std::shared_ptr<StreamSource>> source();

  // The number of pings of a sequence; builds only the first world. Errors: those of source and of
  // SequenceWorlds::info.
  Result<std::uint32_t> pings_of(std::uint32_t sequence);

  // The same as open_sequence; the last sequence is kept.
  Result<std::shared_ptr<const LiveSequence>> sequence(std::uint32_t number,
                                                       const OutputSelection& output,
                                                       const Workers& workers);

 private:
  ScenarioOptions input_;
  BackendChoice backend_ = BackendChoice::cpu;
  Scenario first_;
  std::mutex mutex_;  // protects the members below
  std::shared_ptr<StreamSource> source_;
  struct Last {
    std::uint32_t number = 0;
    std::vector<std::string> flags;
    std::shared_ptr<const LiveSequence> live;
  } last_;
};

struct LaneRequest {
  std::vector<std::uint32_t> listed;            // sequences; if empty:
  std::uint64_t start = 0, stop = 0, step = 1;  // this range
  std::uint32_t skipped = 0;
};

struct StreamRequest {
  std::vector<LaneRequest> lanes;
  std::uint32_t turn = 1;
  std::string split;               // of this split only; empty: all
  std::vector<std::string> flags;  // names from kOutputFlags
  std::optional<PingRange> pings;
  int threads = 1, threads_within = 1, ahead = 4;
};

Result<std::shared_ptr<PingStream>> stream_of(const std::shared_ptr<CheckedScenario>& scenario,
                                              StreamRequest request);

}  // namespace ensonify::python
