// How far a run is: a bar on a terminal, a plain line every 30 s elsewhere, or nothing.
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace ensonify {

enum class ProgressStyle { quiet, lines, bar };

// The bar where stderr is a terminal, lines elsewhere.
ProgressStyle progress_style(bool quiet);

// "12/40 pings, 3.1 pings/s, 9 s left". `made` pings took `seconds`; `left` remain.
std::string progress_text(std::uint64_t done, std::uint64_t total, std::uint64_t made,
                          double seconds);

class Progress {
 public:
  // `found` of `total` pings were there already.
  Progress(ProgressStyle style, std::uint64_t total, std::uint64_t found);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // From any thread.
  void ping_done();
  // More pings that were there already. From any thread.
  void pings_found(std::uint64_t pings);

 private:
  void show();  // with the mutex held
  using Clock = std::chrono::steady_clock;
  ProgressStyle style_;
  std::uint64_t total_, found_, made_ = 0;
  Clock::time_point start_, shown_;
  std::mutex mutex_;
  bool bar_open_ = false;
};

}  // namespace ensonify
