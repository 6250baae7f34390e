// A device that is the host: what CUDA runs, in a loop, with FFTW in double precision behind. It is
// as strict as a device may be: what comes down is there after wait() alone, and what went up must
// still be what it was.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory_resource>
#include <new>
#include <set>
#include <stdexcept>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "synthesis/cuda/queue.h"
#include "synthesis/fft.h"

namespace ensonify::test {

class HostQueue {
 public:
  // `free_bytes` is what it says it has; allocations beyond `limit_bytes` in all fail.
  explicit HostQueue(std::size_t limit_bytes = std::size_t{1} << 40,
                     std::size_t says_free = std::size_t{1} << 40, int threads = 2)
      : limit_(limit_bytes), says_free_(says_free), workers_(threads) {}
  ~HostQueue() {
    for (void* p : held_) std::free(p);
  }

  // Filled with what no result may hang on.
  void* allocate(std::size_t bytes) {
    if (used_ + bytes > limit_) {
      ++refused;
      throw std::bad_alloc();
    }
    used_ += bytes;
    peak = std::max(peak, used_);
    auto* p = static_cast<char*>(std::malloc(bytes + kHeader));
    std::memset(p, 0xff, bytes + kHeader);
    std::memcpy(p, &bytes, sizeof bytes);
    held_.insert(p);
    return p + kHeader;
  }
  void release(void* memory) {
    if (memory == nullptr) return;
    char* p = static_cast<char*>(memory) - kHeader;
    std::size_t bytes = 0;
    std::memcpy(&bytes, p, sizeof bytes);
    used_ -= bytes;
    held_.erase(p);
    std::free(p);
  }
  void upload(void* to, const void* from, std::size_t bytes) {
    std::memcpy(to, from, bytes);
    uploads_.push_back({from, bytes, checksum(from, bytes)});
  }
  void download(void* to, const void* from, std::size_t bytes) {
    downloads_.push_back({to, from, bytes});
    downloaded_bytes += bytes;
  }
  void zero(void* to, std::size_t bytes) { std::memset(to, 0, bytes); }
  void wait() {
    for (const Upload& u : uploads_) {
      if (checksum(u.from, u.bytes) != u.sum) throw std::logic_error("changed before wait()");
    }
    for (const Download& d : downloads_) std::memcpy(d.to, d.from, d.bytes);
    uploads_.clear();
    downloads_.clear();
  }
  std::size_t free_bytes() const { return says_free_; }
  std::size_t held_bytes() const { return used_; }
  std::pmr::memory_resource* host_memory() { return std::pmr::new_delete_resource(); }

  template <class Functor>
  void run(std::int64_t count, const Functor& functor) {
    if (++launches > lost_after) throw DeviceFailure("the host queue is lost, as it was told to");
    // Every second launch runs backwards, since a device promises no order.
    const bool backwards = launches % 2 == 0;
    constexpr std::int64_t kBlock = 4096;
    workers_.for_each((count + kBlock - 1) / kBlock, [&](std::size_t block) {
      const std::int64_t first = std::int64_t(block) * kBlock;
      for (std::int64_t i = first; i < std::min(count, first + kBlock); ++i) {
        functor(backwards ? count - 1 - i : i);
      }
    });
  }

  void transform(Complex32* rows, int length, int at_once, std::int64_t count,
                 FftDirection direction) {
    transform_all(at_once * count, length, direction,
                  [=](std::size_t row, int i) { return rows + row * length + i; });
  }
  void transform_columns(Complex32* data, int length, int columns, std::int64_t count,
                         FftDirection direction) {
    transform_all(columns * count, length, direction, [=](std::size_t column, int i) {
      return data + (column / columns * length + i) * columns + column % columns;
    });
  }

  int launches = 0;
  int refused = 0;                                   // allocations beyond the limit
  int lost_after = std::numeric_limits<int>::max();  // launches
  std::size_t peak = 0;                              // bytes held at once
  std::size_t downloaded_bytes = 0;

 private:
  struct Upload {
    const void* from;
    std::size_t bytes;
    std::uint64_t sum;
  };
  struct Download {
    void* to;
    const void* from;
    std::size_t bytes;
  };
  static std::uint64_t checksum(const void* from, std::size_t bytes) {
    std::uint64_t sum = bytes;
    const auto* at = static_cast<const unsigned char*>(from);
    for (std::size_t i = 0; i < bytes; ++i) sum = (sum ^ at[i]) * 0x100000001b3;
    return sum;
  }

  // at(k, i): value i of transform k.
  template <class At>
  void transform_all(std::size_t count, int length, FftDirection direction, const At& at) {
    const ComplexFft fft(length, direction);
    workers_.for_each(count, [&](std::size_t k) {
      AlignedBuffer<std::complex<double>> data(length);
      for (int i = 0; i < length; ++i) data[i] = {at(k, i)->re, at(k, i)->im};
      fft.run(data.data());
      for (int i = 0; i < length; ++i) {
        *at(k, i) = {static_cast<float>(data[i].real()), static_cast<float>(data[i].imag())};
      }
    });
  }

  static constexpr std::size_t kHeader = 64;
  std::size_t limit_, says_free_, used_ = 0;
  std::set<void*> held_;
  std::vector<Upload> uploads_;
  std::vector<Download> downloads_;
  Workers workers_;
};

}  // namespace ensonify::test
