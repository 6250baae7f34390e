// How often a thing is run, and what is said of it: the median.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>
#include <vector>

namespace ensonify {

class StopWatch {
 public:
  double ms() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

// The lower of the two in the middle of an even number of values.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Median of at least three runs and `seconds`; what runs shorter than that has a run before that
// does not count. `after` cleans up behind each run and is not timed.
template <class Body, class After>
double median_ms(double seconds, Body&& body, After&& after) {
  constexpr std::size_t kFewest = 3, kMost = 1000;
  std::vector<double> runs;
  const StopWatch all;
  bool warm = false;
  while (runs.size() < kFewest || (all.ms() < 1000 * seconds && runs.size() < kMost)) {
    const StopWatch watch;
    body();
    const double ms = watch.ms();
    after();
    if (warm || ms > 1000 * seconds) runs.push_back(ms);
    warm = true;
  }
  return median(std::move(runs));
}

template <class Body>
double median_ms(double seconds, Body&& body) {
  return median_ms(seconds, body, [] {});
}

}  // namespace ensonify
