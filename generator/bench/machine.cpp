#include "bench/machine.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <stdlib.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

#include "bench/kernels.h"
#include "formats/files.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPage = 4096;
constexpr std::size_t kPiece = std::size_t{8} << 20;

std::size_t whole_pages(std::size_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }

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

}  // namespace

double fma_gflops(const KernelTable& kernels, double seconds) {
  constexpr long kRounds = 200'000;
  volatile float sink = 0;
  const double ms = median_ms(seconds, [&] { sink = kernels.multiply_adds(kRounds, 1.0f); });
  return static_cast<double>(kRounds) * kernels.flops_per_round / ms * 1e-6;
}

double copy_gb_s(std::size_t bytes, double seconds) {
  const PageBuffer from(bytes), to(bytes);
  std::memset(from.data(), 1, bytes);
  volatile char sink = 0;
  const double ms = median_ms(seconds, [&] {
    std::memcpy(to.data(), from.data(), bytes);
    sink = to.data()[bytes / 2];
  });
  return 2.0 * static_cast<double>(bytes) / ms * 1e-6;
}

Status measure_disk(const fs::path& folder, std::size_t bytes, MachineReport& machine) {
  struct statfs system {};
  if (::statfs(folder.c_str(), &system) == 0) machine.disk_is_memory = system.f_type == TMPFS_MAGIC;
  const PageBuffer buffer(bytes);
  // Not zeros, since some disks compress them.
  for (std::size_t i = 0; i < bytes; ++i) {
    buffer.data()[i] = static_cast<char>((i * 0x9E3779B97F4A7C15u) >> 56);
  }
  std::vector<double> runs;
  for (int run = 0; run < 3; ++run) {
    const fs::path file = folder / "disk_peak";
    const StopWatch watch;
    if (Status s = write_to_disk(file, buffer.data(), bytes, machine.disk_is_direct); !s) return s;
    runs.push_back(watch.ms());
    fs::remove(file);
  }
  machine.disk_mb_s = static_cast<double>(bytes) / median(runs) * 1e-3;
  return {};
}

Status write_to_disk(const fs::path& file, const char* bytes, std::size_t count, bool& direct) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC;
  int descriptor = ::open(file.c_str(), kFlags | O_DIRECT, 0666);
  direct = descriptor >= 0;
  if (!direct) descriptor = ::open(file.c_str(), kFlags, 0666);
  if (descriptor < 0) return write_error(file, errno);
  const bool written = write_pieces(descriptor, bytes, direct ? whole_pages(count) : count) &&
                       ::ftruncate(descriptor, static_cast<off_t>(count)) == 0 &&
                       ::fdatasync(descriptor) == 0;
  const int error_number = errno;
  ::close(descriptor);
  return written ? Status() : Status(write_error(file, error_number));
}

PageBuffer::PageBuffer(std::size_t bytes) {
  const std::size_t pages = whole_pages(bytes);
  data_ = static_cast<char*>(::operator new(pages, std::align_val_t(kPage)));
  std::memset(data_, 0, pages);
}

PageBuffer::~PageBuffer() { ::operator delete(data_, std::align_val_t(kPage)); }

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

ScratchFolder::ScratchFolder(ScratchFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})) {}

KernelList supported_kernels() {
  KernelList list{{&kSse4Kernels, nullptr, nullptr}, 1};
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    list.table[list.count++] = &kAvx2Kernels;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw")) {
      list.table[list.count++] = &kAvx512Kernels;
    }
  }
  return list;
}

const KernelTable& best_kernels() {
  const KernelList list = supported_kernels();
  return *list.table[list.count - 1];
}

}  // namespace ensonify
