// What a device program asks of a device, and what it works on there. Two classes offer the calls:
// CudaQueue, and HostQueue of the tests, which runs the same functors in a loop.
//
//   void* allocate(std::size_t bytes)        throws std::bad_alloc; release(void*)
//   void upload(void* to, const void* from, std::size_t bytes), download, zero(void*, bytes)
//   std::pmr::memory_resource* host_memory()   of the host, what copies come from and go to fastest
//   void run(std::int64_t count, functor)    functor(i) for all i in [0, count), in any order
//   void transform(Complex32* rows, int length, int at_once, std::int64_t count, FftDirection)
//                                            in place, unscaled, of [count][at_once][length]
//   void wait()                              until all of it is done
//   std::size_t free_bytes(), held_bytes()   of the device; by this queue's allocations
//
// Calls are carried out in their order; only `wait` waits.
//
//   DeviceBuffer   memory of a queue, owned
//   Complex32
//   EchoRecord     one scatterer; amplitude_of
//   DopplerRecord  one that comes back shifted
//   BatchPing      one ping of a batch
//   ArrivalRecord  DirectionRecord  SectorRecord   for an array
//   DeviceKernel   a spreading kernel as polynomials; kernel_at
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/host_device.h"
#include "synthesis/draw.h"

namespace ensonify {

struct Complex32 {
  float re, im;
};

ENSONIFY_HD inline void operator+=(Complex32& sum, Complex32 part) {
  sum.re += part.re;
  sum.im += part.im;
}
ENSONIFY_HD inline Complex32 operator*(float factor, Complex32 z) {
  return {factor * z.re, factor * z.im};
}

ENSONIFY_HD inline Complex32 narrow(ComplexDraw z) {
  return {static_cast<float>(z.re), static_cast<float>(z.im)};
}

// A scatterer, as a ping's list has it, without what synthesis does not need.
struct EchoRecord {
  double delay_s;
  std::uint64_t key;
  float mean_re, mean_im, deviation, gain;
};

// What a shifted scatterer has beside.
struct DopplerRecord {
  std::uint32_t echo;  // of the batch's
  float doppler;
};

// Where its sound seems to come from: so far away, at that cosine with the line.
struct ArrivalRecord {
  double range_m, cosine;
};

// A scatterer in the order of directions, by its index in the batch, and its cell of a PowerGrid.
struct DirectionRecord {
  std::uint32_t echo, cell;
};

// How much of a sector each of two nodes has.
struct SectorRecord {
  std::uint32_t sector;
  float even, odd;
};

// Sector j of the ping has echoes [offset[j], offset[j + 1]) of the batch's.
struct BatchPing {
  std::uint64_t speckle_key, noise_key;
  std::uint32_t speckle_ping, noise_ping;
  float noise_rms;
  std::uint32_t first_offset;  // where the ping's [sectors + 1] begin among the batch's offsets
};

// Amplitude of an echo: its mean alone, or with what is drawn.
ENSONIFY_HD inline Complex32 amplitude_of(const EchoRecord& echo, const BatchPing& ping,
                                          bool means_only) {
  if (means_only) return {echo.mean_re, echo.mean_im};
  return drawn_amplitude<Complex32>(echo.mean_re, echo.mean_im, echo.deviation, ping.speckle_key,
                                    ping.speckle_ping, echo.key);
}

// coefficient [degree + 1][width], highest power of the offset first.
struct DeviceKernel {
  const float* coefficient;
  int width, degree, points;
};

// The value of a kernel's point `tap` for an echo.
ENSONIFY_HD inline float kernel_at(const DeviceKernel& kernel, int tap, float offset) {
  const float* c = kernel.coefficient + tap;
  float sum = 0;
  for (int d = 0; d <= kernel.degree; ++d, c += kernel.width) sum = sum * offset + *c;
  return sum;
}

template <class T, class Queue>
class DeviceBuffer {
 public:
  explicit DeviceBuffer(Queue& queue) : queue_(&queue) {}
  ~DeviceBuffer() { queue_->release(data_); }
  DeviceBuffer(const DeviceBuffer&) = delete;
  DeviceBuffer& operator=(const DeviceBuffer&) = delete;

  // At least n elements; what was there is lost where there were fewer.
  void need(std::size_t n) {
    if (n <= size_) return;
    drop();
    data_ = static_cast<T*>(queue_->allocate(n * sizeof(T)));
    size_ = n;
  }
  // `values` must last until the queue has waited.
  void put(std::span<const T> values) {
    need(values.size());
    if (!values.empty()) queue_->upload(data_, values.data(), values.size_bytes());
  }
  void drop() {
    queue_->release(std::exchange(data_, nullptr));
    size_ = 0;
  }
  T* data() const { return data_; }

 private:
  Queue* queue_;
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace ensonify
