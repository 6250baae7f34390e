// Pings of many sequences, in order, made in advance by separate threads.
//
//   StreamWish  StreamedPing  PingStream
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "core/error.h"
#include "core/ping.h"
#include "run/live_sequence.h"

namespace ensonify {

struct StreamWish {
  // The number of the i-th sequence; empty: there are no more.
  std::function<std::optional<std::uint32_t>(std::uint64_t)> sequence;
  // The same as open_sequence; called from several threads at once.
  std::function<Result<std::shared_ptr<const LiveSequence>>(std::uint32_t, const Workers&)> open;
  std::optional<PingRange> pings = {};  // of each sequence, if it has them; absent: all
  std::uint32_t skipped = 0;            // pings of the first sequence that are not made
  int threads = 1;                      // that make pings in parallel
  int threads_within = 1;               // for each ping
  int ahead = 4;  // pings made or in progress, not taken yet; at most twice as many
};

struct StreamedPing {
  std::shared_ptr<const SequenceInfo> info;
  std::shared_ptr<const PipelineTables> tables;
  PingRange pings;  // of its sequence
  PingResult result;
};

// A sequence that cannot be made is returned as an error in place of its pings, and the next one
// follows. The number of open sequences is at most the number of threads plus one.
class PingStream {
 public:
  explicit PingStream(StreamWish wish);
  // Waits for the pings in progress, at most one per thread.
  ~PingStream();
  PingStream(const PingStream&) = delete;
  PingStream& operator=(const PingStream&) = delete;

  // Returns whether next() has a result, after waiting at most this long.
  bool wait(std::chrono::milliseconds most);

  // Waits for the next result; empty at the end. Rethrows an exception that occurred while the
  // result was made, which ends the stream.
  std::optional<Result<StreamedPing>> next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ensonify
