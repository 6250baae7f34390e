// Pings of many sequences, in order, made in advance by separate threads.
//
//   StreamLane  StreamWish  StreamedPing  PingStream
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/error.h"
#include "core/ping.h"
#include "run/live_sequence.h"

namespace ensonify {

struct StreamLane {
  // Returns the next sequence at each call; empty: there are no more. Calls do not overlap.
  std::function<std::optional<std::uint32_t>()> next_sequence;
  std::uint32_t skipped = 0;  // pings of the first sequence that are not made
};

struct StreamWish {
  // Pings are taken from the lanes in turn, as many as `turn` from each. A lane without further
  // sequences is left out.
  std::vector<StreamLane> lanes;
  std::uint32_t turn = 1;
  // The same as open_sequence; called from several threads at once.
  std::function<Result<std::shared_ptr<const LiveSequence>>(std::uint32_t, const Workers&)> open;
  std::optional<PingRange> pings = {};  // of each sequence, if it has them; absent: all
  int threads = 1;                      // that make pings in parallel
  int threads_within = 1;               // for each ping
  // The next pings in the order of taking that are made before they are taken. Fewer pings than
  // twice as many exist at a time, even if sequences differ in length.
  int ahead = 4;
};

struct StreamedPing {
  std::shared_ptr<const SequenceInfo> info;
  std::shared_ptr<const PipelineTables> tables;
  PingRange pings;  // of its sequence
  PingResult result;
};

// A sequence that cannot be made is returned as an error in place of its pings, and the next one
// follows. The world of a sequence is freed when its last ping is made; the number of worlds is at
// most that of threads plus that of lanes.
class PingStream {
 public:
  explicit PingStream(StreamWish wish);
  // Waits for the pings in progress, at most one per thread.
  ~PingStream();
  PingStream(const PingStream&) = delete;
  PingStream& operator=(const PingStream&) = delete;

  // Returns whether next() has a result, after waiting at most this long.
  bool wait(std::chrono::milliseconds most);

  // Waits for the next result; empty at the end. Rethrows an exception that occurred while this
  // result was made, which ends the stream.
  std::optional<Result<StreamedPing>> next();

  // The pings that are made and not taken.
  std::size_t ready() const;
  // Whether the threads have nothing to do before a ping is taken.
  bool is_resting() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ensonify
