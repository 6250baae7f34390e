// A device that is the host: what CUDA runs, in a loop, with FFTW in double precision behind.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>
#include <set>

#include "core/parallel.h"
#include "synthesis/cpu/fft.h"
#include "synthesis/cuda/records.h"

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
    if (used_ + bytes > limit_) throw std::bad_alloc();
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
  void upload(void* to, const void* from, std::size_t bytes) { std::memcpy(to, from, bytes); }
  void download(void* to, const void* from, std::size_t bytes) { std::memcpy(to, from, bytes); }
  void zero(void* to, std::size_t bytes) { std::memset(to, 0, bytes); }
  void wait() {}
  std::size_t free_bytes() const { return says_free_; }

  template <class Functor>
  void run(std::int64_t count, const Functor& functor) {
    ++launches;
    constexpr std::int64_t kBlock = 4096;
    workers_.for_each((count + kBlock - 1) / kBlock, [&](std::size_t block) {
      const std::int64_t first = std::int64_t(block) * kBlock;
      for (std::int64_t i = first; i < std::min(count, first + kBlock); ++i) functor(i);
    });
  }

  void transform(Complex32* rows, int length, int count, FftDirection direction) {
    const ComplexFft fft(length, direction);
    workers_.for_each(count, [&](std::size_t row) {
      AlignedBuffer<std::complex<double>> data(length);
      Complex32* at = rows + row * length;
      for (int i = 0; i < length; ++i) data[i] = {at[i].re, at[i].im};
      fft.run(data.data());
      for (int i = 0; i < length; ++i) {
        at[i] = {static_cast<float>(data[i].real()), static_cast<float>(data[i].imag())};
      }
    });
  }

  int launches = 0;
  std::size_t peak = 0;  // bytes held at once

 private:
  static constexpr std::size_t kHeader = 64;
  std::size_t limit_, says_free_, used_ = 0;
  std::set<void*> held_;
  Workers workers_;
};

}  // namespace ensonify::test
