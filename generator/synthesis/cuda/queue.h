// The interface between device programs and a device, and the types on the device. Two classes
// implement the calls: CudaQueue, and the HostQueue of the tests, which runs the same functors in a
// loop.
//
//   void* allocate(std::size_t bytes)        throws std::bad_alloc; release(void*)
//   void upload(void* to, const void* from, std::size_t bytes), download, zero(void*, bytes)
//   std::pmr::memory_resource* host_memory()   host memory from and to which copies are fastest; it
//                                            outlives the queue
//   void run(std::int64_t count, functor)    functor(i) for all i in [0, count), in any order
//   void transform(Complex32* rows, int length, int at_once, std::int64_t count, FftDirection)
//                                            in place, unscaled, for [count][at_once][length]
//   void transform_columns(Complex32* data, int length, int columns, std::int64_t count,
//                          FftDirection)     the same for [count][length][columns]
//   void wait()                              waits until all calls are complete
//   std::size_t free_bytes(), held_bytes()   free on the device; allocated by this queue
//
// Calls are executed in their order. Only `wait` blocks.
//
//   DeviceBuffer   owned memory of a queue
//   Complex32
//   EchoRecord     one scatterer; amplitude_of
//   DopplerRecord  one scatterer with Doppler
//   BatchPing      one ping of a batch
//   ArrivalRecord  DirectionRecord   for an array
//   SectorRecord  BeamWeights        from beam cells to nodes, from nodes to beams
//   PointWeights                     from moments of cells to points of a grid
//   ElementTaps  ElementWeight  NodePiece    from an array's elements to beams
//   DeviceKernel   a spreading kernel as polynomials; kernel_at
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/compile_targets.h"
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

// The members of a Scatterer that synthesis needs.
struct EchoRecord {
  double delay_s;
  std::uint64_t key;
  float mean_re, mean_im, deviation, gain;
};

// The additional data of a scatterer with Doppler.
struct DopplerRecord {
  std::uint32_t echo;  // index in the batch
  float doppler;
};

// The apparent point of a scatterer: its range, and the cosine between its direction and the line.
struct ArrivalRecord {
  double range_m, cosine;
};

// An entry of the order by directions: a scatterer's index in the batch, and its cell of a
// PowerGrid.
struct DirectionRecord {
  std::uint32_t echo, cell;
};

// The weights of a sector (beam cell) at an even node and the odd node after it.
struct SectorRecord {
  std::uint32_t sector;
  float even, odd;
};

// A thread computes one sample of this number of neighboring beams, and reads the sample of each
// node once for all of them.
constexpr int kBeamsAThread = 16;

// The weights of a node in these beams, aligned so that a thread reads four at once.
struct alignas(16) BeamWeights {
  float of_beam[kBeamsAThread];
};

// A thread computes this number of neighboring points of an element's grid. The weights of one
// moment at them are aligned so that a thread reads all at once.
constexpr int kPointsAThread = 4;
struct alignas(16) PointWeights {
  float of_point[kPointsAThread];
};

// The taps that interpolate an element's record at the delay of a beam, at twice its sampling rate.
constexpr int kElementTaps = 8;
struct alignas(16) ElementTaps {
  float of_tap[kElementTaps];
};

// The weight of an element for nodes, a polynomial of the frequency with the constant term last.
struct alignas(16) ElementWeight {
  float power[4];
};

// A thread sums this number of samples of a beam from nodes, kGridLanes apart.
constexpr int kSamplesAThread = 4;

// Samples [first, first + count) of one stretch, at most kSamplesAThread * kGridLanes, with the
// size of its coefficients and where they begin.
struct NodePiece {
  std::int64_t coefficient;
  std::int32_t stretch, first, count;
  std::int32_t orders, taps, degree;
};

// Sector (beam cell) j of a ping has the batch's echoes [offset[j], offset[j + 1]).
struct BatchPing {
  std::uint64_t speckle_key, noise_key;
  std::uint32_t speckle_ping, noise_ping;
  float noise_rms;
  std::uint32_t first_offset;  // index of the ping's [sectors + 1] in the batch's offsets
};

// The amplitude of an echo: its mean only, or with the drawn part.
ENSONIFY_HD inline Complex32 amplitude_of(const EchoRecord& echo, const BatchPing& ping,
                                          bool means_only) {
  if (means_only) return {echo.mean_re, echo.mean_im};
  return drawn_amplitude<Complex32>(echo.mean_re, echo.mean_im, echo.deviation, ping.speckle_key,
                                    ping.speckle_ping, echo.key);
}

// coefficient: [degree + 1][width], highest power of the offset first.
struct DeviceKernel {
  const float* coefficient;
  int width, degree, points;
};

// The value of a kernel at its point `tap`, for an echo with this offset.
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

  // Provides at least n elements. If the buffer has to grow, its contents are lost.
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
