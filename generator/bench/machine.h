// Speeds of the machine that limit every data set, and a folder for what is measured.
//
//   MachineReport  measure_machine
//   StopWatch  median  ScratchFolder
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"

namespace ensonify {

struct MachineReport {
  int threads = 0;
  std::string simd;
  double copy_gb_s = 0;  // of one core, bytes read and bytes written both counted
  double disk_mb_s = 0;  // past the page cache, in one stream
  bool disk_is_memory = false;
  // False: the file system has no O_DIRECT, so the file was written and synchronized.
  bool disk_is_direct = true;
};

inline constexpr std::size_t kMachineBytes = std::size_t{256} << 20;

// Copies and writes `bytes`, a multiple of 4096, three times each, and takes the medians. Error
// (io): the folder cannot be written.
Result<MachineReport> measure_machine(const std::filesystem::path& folder, int threads,
                                      std::size_t bytes = kMachineBytes);

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
double median(std::vector<double> values);

// A new folder in `parent`, which the destructor removes with its content.
class ScratchFolder {
 public:
  static Result<ScratchFolder> make(const std::filesystem::path& parent);
  ~ScratchFolder();
  ScratchFolder(ScratchFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  ScratchFolder& operator=(ScratchFolder&&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  explicit ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

}  // namespace ensonify
