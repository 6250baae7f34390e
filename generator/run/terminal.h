// Messages, progress and interrupts of the program.
//
//   tell             to standard error; a failure to write a message does not end the work
//   answer           to standard output: requested output
//   answers_written  whether all output could be written
//   Pace  progress_text
//   Progress  progress_style    a bar on a terminal, a line every 30 s elsewhere
//   expect_interrupts  listen_for_interrupts  interrupted
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
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

// ErrorKind::io if standard output did not accept everything, as on a full disk.
Status answers_written();

enum class ProgressStyle { quiet, lines, bar };

// The bar if stderr is a terminal, otherwise lines.
ProgressStyle progress_style(bool quiet);

// The rate of the work, without the time that its start took.
class Pace {
 public:
  // Another ping was made this long after the start.
  void add(double seconds);
  std::uint64_t made() const { return made_; }
  // Of about the latest half of the pings; absent until these have taken a third of the time.
  std::optional<double> per_s(double seconds) const;

 private:
  bool is_known(double seconds) const;
  struct Mark {
    std::uint64_t made = 0;
    double seconds = 0;
  };
  std::uint64_t made_ = 0;
  Mark half_, quarter_;  // at each doubling: the last one and the one before
  bool known_ = false;
};

// "12/40 pings, 3.1 pings/s, 9 s left", or "1/40 pings, ..." before the rate is known; at the end
// with the rate of the whole work.
std::string progress_text(std::uint64_t done, std::uint64_t total, const Pace& pace, double seconds,
                          std::string_view what = "ping");

class Progress {
 public:
  // `found` of `total` pings (or of `what` is counted) existed before.
  Progress(ProgressStyle style, std::uint64_t total, std::uint64_t found,
           std::string_view what = "ping");
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // May be called from any thread.
  void one_done();
  // Adds pings that existed before. May be called from any thread.
  void pings_found(std::uint64_t pings);
  // Corrects the total: `assumed` of it are `actual`. May be called from any thread.
  void correct_total(std::uint64_t assumed, std::uint64_t actual);

 private:
  void show();  // with the mutex held
  double seconds() const;
  using Clock = std::chrono::steady_clock;
  ProgressStyle style_;
  std::uint64_t total_, found_;
  Pace pace_;
  std::string what_;
  Clock::time_point start_, shown_;
  std::mutex mutex_;
  bool bar_open_ = false;
};

// SIGINT, SIGTERM and SIGHUP: after listen_for_interrupts, the run finishes the current pings and
// ends. After expect_interrupts, when nothing has been written yet, SIGINT and SIGTERM end the
// program at once with status 130.
void expect_interrupts();
void listen_for_interrupts();
bool interrupted();

}  // namespace ensonify
