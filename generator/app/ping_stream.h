// Pings of many sequences, in order, made ahead by threads of their own.
//
//   StreamWish  StreamedPing  PingStream
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "app/live_sequence.h"
#include "core/error.h"
#include "core/ping.h"

namespace ensonify {

struct StreamWish {
  // The number of the i-th sequence; none: there are no more.
  std::function<std::optional<std::uint32_t>(std::uint64_t)> sequence;
  // As open_sequence; called from several threads at once.
  std::function<Result<std::shared_ptr<const LiveSequence>>(std::uint32_t, const Workers&)> open;
  std::optional<PingRange> pings = {};  // of each sequence, as far as it has them; absent: all
  std::uint32_t skipped = 0;            // pings of the first sequence that are not made
  int threads = 1;                      // that make pings side by side
  int threads_within = 1;               // of each ping
  int ahead = 4;  // pings that are made or under way and not taken yet; at most twice as many
};

struct StreamedPing {
  std::shared_ptr<const SequenceInfo> info;
  std::shared_ptr<const PipelineTables> tables;
  PingRange pings;  // of its sequence
  PingResult result;
};

// A sequence that cannot be made takes the place of its pings as an error, and the next one
// follows. As many sequences are open as there are threads, and one.
class PingStream {
 public:
  explicit PingStream(StreamWish wish);
  // Waits for the pings under way, at most one a thread.
  ~PingStream();
  PingStream(const PingStream&) = delete;
  PingStream& operator=(const PingStream&) = delete;

  // Whether next() has an answer, after at most so long.
  bool wait(std::chrono::milliseconds most);

  // Waits for it. None: the end. Throws what making it has thrown; the stream has ended then.
  std::optional<Result<StreamedPing>> next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ensonify
