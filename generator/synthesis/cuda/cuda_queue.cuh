// The queue of a CUDA device for device programs (queue.h).
#pragma once

#include <cuda_runtime.h>
#include <cufft.h>

#include <array>
#include <map>
#include <memory_resource>
#include <string>
#include <unordered_map>

#include "core/error.h"
#include "synthesis/cuda/queue.h"
#include "synthesis/fft.h"

namespace ensonify {

// Throws std::bad_alloc if memory does not suffice, and DeviceFailure with the driver's message on
// other errors.
void check_cuda(cudaError_t error, const char* doing);
void check_cufft(cufftResult result, const char* doing);

template <class Functor>
__global__ void run_functor(std::int64_t count, Functor functor) {
  const std::int64_t stride = std::int64_t{gridDim.x} * blockDim.x;
  for (std::int64_t i = std::int64_t{blockIdx.x} * blockDim.x + threadIdx.x; i < count;
       i += stride) {
    functor(i);
  }
}

// Page-locked host memory, so that copies run in parallel with work of the processor. If the system
// cannot lock more memory, ordinary memory replaces it. Copies are then slower, but work the same.
class LockedMemory final : public std::pmr::memory_resource {
  void* do_allocate(std::size_t bytes, std::size_t alignment) override;
  void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override;
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }
};

class CudaQueue {
 public:
  explicit CudaQueue(int device);
  ~CudaQueue();
  CudaQueue(const CudaQueue&) = delete;
  CudaQueue& operator=(const CudaQueue&) = delete;

  void* allocate(std::size_t bytes);
  void release(void* memory);
  void upload(void* to, const void* from, std::size_t bytes);
  void download(void* to, const void* from, std::size_t bytes);
  void zero(void* to, std::size_t bytes);
  void transform(Complex32* rows, int length, int at_once, std::int64_t count,
                 FftDirection direction);
  void transform_columns(Complex32* data, int length, int columns, std::int64_t count,
                         FftDirection direction);
  void wait();
  std::size_t free_bytes();
  std::size_t held_bytes() const { return held_bytes_; }
  static std::pmr::memory_resource* host_memory();

  template <class Functor>
  void run(std::int64_t count, const Functor& functor) {
    if (count == 0) return;
    constexpr int kThreads = 256;
    constexpr std::int64_t kMostBlocks = std::int64_t{1} << 30;
    const std::int64_t blocks = std::min((count + kThreads - 1) / kThreads, kMostBlocks);
    use();
    run_functor<<<static_cast<unsigned>(blocks), kThreads, 0, stream_>>>(count, functor);
    check_cuda(cudaGetLastError(), "launching a kernel");
  }

 private:
  void use();  // makes the calling thread use this device
  // `stride` is the distance between the values of one transform.
  cufftHandle plan(int length, int at_once, int stride);
  void transform_all(cufftHandle plan, Complex32* data, std::int64_t size, std::int64_t count,
                     FftDirection direction);

  int device_;
  cudaStream_t stream_ = nullptr;
  std::size_t held_bytes_ = 0;
  std::unordered_map<void*, std::size_t> bytes_of_;
  // Plans by length, rows at once, and stride. The number of rows in a batch does not select the
  // plan, because results would then depend on the batch.
  std::map<std::array<int, 3>, cufftHandle> plans_;
};

}  // namespace ensonify
