#include "bench/machine.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <stdlib.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <new>

#include "core/runtime.h"
#include "formats/files.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// Files are written past the page cache from and in whole pages.
constexpr std::align_val_t kPage{4096};
constexpr std::size_t kPiece = std::size_t{8} << 20;
constexpr int kRuns = 3;

struct FreePages {
  void operator()(char* pages) const { ::operator delete(pages, kPage); }
};

// Not zeros, since some disks compress them.
std::unique_ptr<char, FreePages> filled_pages(std::size_t bytes) {
  std::unique_ptr<char, FreePages> pages(static_cast<char*>(::operator new(bytes, kPage)));
  for (std::size_t i = 0; i < bytes; ++i) {
    pages.get()[i] = static_cast<char>((i * 0x9E3779B97F4A7C15u) >> 56);
  }
  return pages;
}

// Median time of some runs.
template <class Body>
double timed_ms(Body&& body) {
  std::vector<double> runs;
  for (int run = 0; run < kRuns; ++run) {
    const StopWatch watch;
    body();
    runs.push_back(watch.ms());
  }
  return median(std::move(runs));
}

bool write_pieces(int file, const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t done = ::write(file, bytes, std::min(count, kPiece));
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) return false;
    bytes += done;
    count -= static_cast<std::size_t>(done);
  }
  return true;
}

// Writes a new file past the page cache where the file system allows that, and waits until the disk
// has it. `direct` returns whether the page cache was bypassed.
Status write_to_disk(const fs::path& file, const char* pages, std::size_t bytes, bool& direct) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC;
  int descriptor = ::open(file.c_str(), kFlags | O_DIRECT, 0666);
  direct = descriptor >= 0;
  if (!direct) descriptor = ::open(file.c_str(), kFlags, 0666);
  if (descriptor < 0) return write_error(file, errno);
  const bool written = write_pieces(descriptor, pages, bytes) && ::fdatasync(descriptor) == 0;
  const int error_number = errno;
  ::close(descriptor);
  return written ? Status() : Status(write_error(file, error_number));
}

}  // namespace

Result<MachineReport> measure_machine(const fs::path& folder, int threads, std::size_t bytes) {
  MachineReport machine;
  machine.threads = threads;
  machine.simd = simd_level_name(best_simd_level());
  const auto from = filled_pages(bytes), to = filled_pages(bytes);
  volatile char sink = 0;
  const double copy_ms = timed_ms([&] {
    std::memcpy(to.get(), from.get(), bytes);
    sink = to.get()[bytes / 2];
  });
  machine.copy_gb_s = 2.0 * static_cast<double>(bytes) / copy_ms * 1e-6;
  struct statfs system {};
  if (::statfs(folder.c_str(), &system) == 0) machine.disk_is_memory = system.f_type == TMPFS_MAGIC;
  // Every run writes a new file, since emptying an old one takes time.
  std::vector<fs::path> files;
  Status written;
  const double disk_ms = timed_ms([&] {
    files.push_back(folder / ("disk_speed_" + std::to_string(files.size())));
    if (written) written = write_to_disk(files.back(), from.get(), bytes, machine.disk_is_direct);
  });
  std::error_code ignored;
  for (const fs::path& file : files) fs::remove(file, ignored);
  if (!written) return written.error();
  machine.disk_mb_s = static_cast<double>(bytes) / disk_ms * 1e-3;
  return machine;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + (std::ssize(values) - 1) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Result<ScratchFolder> ScratchFolder::make(const fs::path& parent) {
  const fs::path name_pattern = parent / "ensonify-bench-XXXXXX";
  std::string name = name_pattern.string();
  if (::mkdtemp(name.data()) == nullptr) return write_error(name_pattern, errno);
  return ScratchFolder(name);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

}  // namespace ensonify
