// The program and whoever started it: what it says, how far it is, and how it is stopped.
//
//   tell             to standard error: a message that cannot be written does not end the work
//   answer           to standard output: what was asked for
//   answers_written  whether all answers came through
//   Progress  progress_style  progress_text    a bar on a terminal, a line every 30 s elsewhere
//   expect_interrupts  listen_for_interrupts  interrupted
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.h"

namespace ensonify {

void tell_text(std::string_view text);
void answer_text(std::string_view text);

template <class... T>
void tell(fmt::format_string<T...> format, T&&... values) {
  tell_text(fmt::format(format, std::forward<T>(values)...));
}

template <class... T>
void answer(fmt::format_string<T...> format, T&&... values) {
  answer_text(fmt::format(format, std::forward<T>(values)...));
}

// ErrorKind::io where standard output did not take everything, as on a full disk.
Status answers_written();

enum class ProgressStyle { quiet, lines, bar };

// The bar where stderr is a terminal, lines elsewhere.
ProgressStyle progress_style(bool quiet);

// "12/40 pings, 3.1 pings/s, 9 s left". `made` of them took `seconds`.
std::string progress_text(std::uint64_t done, std::uint64_t total, std::uint64_t made,
                          double seconds, std::string_view what = "ping");

class Progress {
 public:
  // `found` of `total` pings, or of `what` is counted, were there already.
  Progress(ProgressStyle style, std::uint64_t total, std::uint64_t found,
           std::string_view what = "ping");
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // From any thread.
  void one_done();
  // More pings that were there already. From any thread.
  void pings_found(std::uint64_t pings);
  // So many of the total are in fact as many as `actual`. From any thread.
  void correct_total(std::uint64_t assumed, std::uint64_t actual);

 private:
  void show();  // with the mutex held
  using Clock = std::chrono::steady_clock;
  ProgressStyle style_;
  std::uint64_t total_, found_, made_ = 0;
  std::string what_;
  Clock::time_point start_, shown_;
  std::mutex mutex_;
  bool bar_open_ = false;
};

// SIGINT, SIGTERM and SIGHUP: after listen_for_interrupts the ping in hand is finished, then the
// run ends. After expect_interrupts, when nothing has been written yet, the first two end the
// program with 130 at once.
void expect_interrupts();
void listen_for_interrupts();
bool interrupted();

}  // namespace ensonify
