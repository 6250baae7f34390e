// A scenario and its worlds, as the module `_core` holds them.
//
//   claim_process    before anything is built
//   CheckedScenario  its first world is built when that is asked for
//   StreamRequest  stream_of
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

#include "app/live_sequence.h"
#include "app/ping_stream.h"

namespace ensonify::python {

// Worlds bring threads and the library that traces rays with them, which a fork does not take along.
// The first process of a family that builds one is the only one that may. Error (device): this is
// another one.
Status claim_process();

class CheckedScenario {
 public:
  // Errors: those of parse_scenario and check_draws. Starts no thread.
  static Result<std::shared_ptr<CheckedScenario>> open(ScenarioOptions input,
                                                       BackendChoice backend);

  const ScenarioOptions& input() const { return input_; }
  const Scenario& first() const { return first_; }  // as drawn for sequence 0

  // The text of the scenario as it was drawn for the sequence, without distributions. Errors: those
  // of source and SequenceWorlds::session.
  Result<std::string> sample(std::uint32_t sequence);

  // From any thread. Errors: those of open_source and claim_process.
  Result<std::shared_ptr<StreamSource>> source();

  // How many pings a sequence has; builds no world but the first. Errors: those of source, and of
  // SequenceWorlds::info.
  Result<std::uint32_t> pings_of(std::uint32_t sequence);

  // As open_sequence; the last one is kept.
  Result<std::shared_ptr<const LiveSequence>> sequence(std::uint32_t number,
                                                       const OutputSelection& output,
                                                       const Workers& workers);

 private:
  ScenarioOptions input_;
  BackendChoice backend_ = BackendChoice::cpu;
  Scenario first_;
  std::mutex mutex_;  // of what follows
  std::shared_ptr<StreamSource> source_;
  struct Last {
    std::uint32_t number = 0;
    std::vector<std::string> flags;
    std::shared_ptr<const LiveSequence> live;
  } last_;
};

struct StreamRequest {
  std::vector<std::uint32_t> listed;              // sequences; where it is empty:
  std::uint64_t start = 0, stop = 0, step = 1;  // ... and
  std::string split;                              // ... those of this one alone; empty: all
  std::vector<std::string> flags;                 // of kOutputFlags
  std::optional<PingRange> pings;
  std::uint32_t skipped = 0;
  int threads = 1, threads_within = 1, ahead = 4;
};

Result<std::shared_ptr<PingStream>> stream_of(const std::shared_ptr<CheckedScenario>& scenario,
                                              StreamRequest request);

}  // namespace ensonify::python
