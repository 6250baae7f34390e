#include "run/terminal.h"

#include <time.h>
#include <unistd.h>

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <utility>

#include "core/counted.h"
#include "core/error.h"

namespace ensonify {

void tell_text(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

void answer_text(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stdout); }

Status answers_written() {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return {};
  return Error{ErrorKind::io,
               fmt::format("standard output: cannot be written{}{}", errno != 0 ? ": " : "",
                           errno != 0 ? std::strerror(errno) : "")};
}

namespace {

constexpr int kBarWidth = 30;
constexpr std::chrono::milliseconds kBarInterval{100};
constexpr std::chrono::seconds kLineInterval{30};

std::string duration_text(double seconds) {
  const long s = std::lround(seconds);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s / 60 % 60);
}

}  // namespace

ProgressStyle progress_style(bool quiet) {
  if (quiet) return ProgressStyle::quiet;
  return isatty(STDERR_FILENO) != 0 ? ProgressStyle::bar : ProgressStyle::lines;
}

void Pace::add(double seconds) {
  ++made_;
  if (made_ >= 2 * half_.made) quarter_ = std::exchange(half_, {made_, seconds});
  known_ = is_known(seconds);
}

// The first ping includes the start, and the first ones of several threads come at the same time.
bool Pace::is_known(double seconds) const {
  if (known_) return true;
  return quarter_.made > 0 && made_ >= quarter_.made + 2 &&
         3 * (seconds - quarter_.seconds) >= seconds;
}

std::optional<double> Pace::per_s(double seconds) const {
  const double took = seconds - quarter_.seconds;
  if (!is_known(seconds) || !(took > 0)) return std::nullopt;
  return static_cast<double>(made_ - quarter_.made) / took;
}

std::string progress_text(std::uint64_t done, std::uint64_t total, const Pace& pace, double seconds,
                          std::string_view what) {
  const std::string text = fmt::format("{}/{}", done, counted(total, what));
  if (done >= total) {
    if (pace.made() == 0 || !(seconds > 0)) return text;
    return text + fmt::format(", {:.3g} {}s/s", static_cast<double>(pace.made()) / seconds, what);
  }
  const auto rate = pace.per_s(seconds);
  if (!rate) return text + ", ...";
  return text + fmt::format(", {:.3g} {}s/s, {} left", *rate, what,
                            duration_text(static_cast<double>(total - done) / *rate));
}

Progress::Progress(ProgressStyle style, std::uint64_t total, std::uint64_t found,
                   std::string_view what)
    : style_(style),
      total_(total),
      found_(found),
      what_(what),
      start_(Clock::now()),
      shown_(start_) {
  if (style_ == ProgressStyle::bar) show();
}

Progress::~Progress() {
  if (style_ == ProgressStyle::quiet) return;
  if (pace_.made() > 0) show();
  if (bar_open_) tell("\n");
}

void Progress::pings_found(std::uint64_t pings) {
  const std::lock_guard lock(mutex_);
  found_ += pings;
}

void Progress::correct_total(std::uint64_t assumed, std::uint64_t actual) {
  const std::lock_guard lock(mutex_);
  total_ = total_ + actual - std::min(total_, assumed);
}

void Progress::one_done() {
  const std::lock_guard lock(mutex_);
  pace_.add(seconds());
  if (style_ == ProgressStyle::quiet) return;
  const auto wait =
      style_ == ProgressStyle::bar ? Clock::duration(kBarInterval) : Clock::duration(kLineInterval);
  if (Clock::now() - shown_ >= wait) show();
}

double Progress::seconds() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

void Progress::show() {
  shown_ = Clock::now();
  const std::uint64_t done = found_ + pace_.made();
  const std::string text = progress_text(done, total_, pace_, seconds(), what_);
  if (style_ == ProgressStyle::lines) {
    tell("{}\n", text);
    return;
  }
  const auto filled = static_cast<int>(total_ > 0 ? kBarWidth * done / total_ : kBarWidth);
  tell("\r[{:<{}}] {}\033[K", std::string(filled, '#'), kBarWidth, text);
  bar_open_ = true;
}

namespace {

// A signal handler reaches only variables of the process; the threads check this one.
std::atomic<bool> g_interrupted = false;

// Batch systems signal a script and its program at once, and the script passes its signal on, so
// signals within this time count as one.
constexpr long long kOneSignal_ns = 1'000'000'000;
std::atomic<long long> g_first_ns = 0;
static_assert(std::atomic<bool>::is_always_lock_free);
static_assert(std::atomic<long long>::is_always_lock_free);

extern "C" void remember_signal(int signal) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const long long now_ns = now.tv_sec * 1'000'000'000LL + now.tv_nsec;
  g_interrupted = true;
  long long first_ns = 0;
  if (g_first_ns.compare_exchange_strong(first_ns, now_ns)) return;
  if (now_ns - first_ns < kOneSignal_ns) return;
  // A second signal ends the program at once; complete files are kept anyway.
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

extern "C" void end_at_once(int) { _exit(exit_code(ErrorKind::interrupted)); }

}  // namespace

void expect_interrupts() {
  std::signal(SIGINT, end_at_once);
  std::signal(SIGTERM, end_at_once);
}

void listen_for_interrupts() {
  std::signal(SIGINT, remember_signal);
  std::signal(SIGTERM, remember_signal);
  // SIGHUP comes from a terminal that was closed; `nohup` makes the process ignore it.
  if (std::signal(SIGHUP, remember_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

bool interrupted() { return g_interrupted; }

}  // namespace ensonify
