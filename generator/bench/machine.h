// Peak speeds of the machine, with which stages are compared, and repeated timing by the median.
//
//   StopWatch  median  median_ms
//   fma_gflops  copy_gb_s  measure_disk
//   write_to_disk  PageBuffer  ScratchFolder
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bench/bench.h"
#include "bench/kernels.h"

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

// Median of at least three runs and `seconds`; shorter work has an extra first run that does not
// count. `after` cleans up after each run and is not timed.
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

double fma_gflops(const KernelTable& kernels, double seconds);
double copy_gb_s(std::size_t bytes, double seconds);

// Fills in the values of the disk. Error (io): the folder cannot be written.
Status measure_disk(const std::filesystem::path& folder, std::size_t bytes, MachineReport& machine);

// Writes a new file past the page cache where the file system allows that, and waits until the disk
// has it. The bytes must begin on a 4096-byte boundary and have room up to a multiple of 4096.
// `direct` returns whether the page cache was bypassed. Error (io).
Status write_to_disk(const std::filesystem::path& file, const char* bytes, std::size_t count,
                     bool& direct);

// Memory aligned for write_to_disk.
class PageBuffer {
 public:
  explicit PageBuffer(std::size_t bytes);  // zero at first; throws std::bad_alloc
  ~PageBuffer();
  PageBuffer(const PageBuffer&) = delete;
  PageBuffer& operator=(const PageBuffer&) = delete;
  char* data() const { return data_; }

 private:
  char* data_;
};

// A new folder in `parent`, which the destructor removes with its content.
class ScratchFolder {
 public:
  static Result<ScratchFolder> make(const std::filesystem::path& parent);
  ~ScratchFolder();
  ScratchFolder(ScratchFolder&& other) noexcept;
  ScratchFolder& operator=(ScratchFolder&&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  explicit ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

}  // namespace ensonify
