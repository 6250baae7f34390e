#include "app/progress.h"
#include "app/print.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace ensonify {
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

std::string progress_text(std::uint64_t done, std::uint64_t total, std::uint64_t made,
                          double seconds) {
  std::string text = fmt::format("{}/{} pings", done, total);
  if (made == 0 || !(seconds > 0)) return text;
  const double rate = static_cast<double>(made) / seconds;
  text += fmt::format(", {:.3g} pings/s", rate);
  if (done < total) {
    text += fmt::format(", {} left", duration_text(static_cast<double>(total - done) / rate));
  }
  return text;
}

Progress::Progress(ProgressStyle style, std::uint64_t total, std::uint64_t found)
    : style_(style), total_(total), found_(found), start_(Clock::now()), shown_(start_) {
  if (style_ == ProgressStyle::bar) show();
}

Progress::~Progress() {
  if (style_ == ProgressStyle::quiet) return;
  if (made_ > 0) show();
  if (bar_open_) tell("\n");
}

void Progress::pings_found(std::uint64_t pings) {
  const std::lock_guard lock(mutex_);
  found_ += pings;
}

void Progress::ping_done() {
  const std::lock_guard lock(mutex_);
  ++made_;
  if (style_ == ProgressStyle::quiet) return;
  const auto wait =
      style_ == ProgressStyle::bar ? Clock::duration(kBarInterval) : Clock::duration(kLineInterval);
  if (Clock::now() - shown_ >= wait) show();
}

void Progress::show() {
  shown_ = Clock::now();
  const std::uint64_t done = found_ + made_;
  const std::string text =
      progress_text(done, total_, made_, std::chrono::duration<double>(shown_ - start_).count());
  if (style_ == ProgressStyle::lines) {
    tell("{}\n", text);
    return;
  }
  const auto filled = static_cast<int>(total_ > 0 ? kBarWidth * done / total_ : kBarWidth);
  tell("\r[{:<{}}] {}\033[K", std::string(filled, '#'), kBarWidth, text);
  bar_open_ = true;
}

}  // namespace ensonify
