#include "synthesis/cuda/cuda_queue.cuh"

#include <algorithm>
#include <cstdlib>
#include <new>

namespace ensonify {
namespace {

constexpr std::size_t kPage = 4096;

}  // namespace

void check_cuda(cudaError_t error, const char* doing) {
  if (error == cudaSuccess) return;
  if (error == cudaErrorMemoryAllocation) {
    cudaGetLastError();  // clears the error, which the next call would report again
    throw std::bad_alloc();
  }
  throw DeviceFailure(std::string("CUDA, ") + doing + ": " + cudaGetErrorString(error));
}

void check_cufft(cufftResult result, const char* doing) {
  if (result == CUFFT_SUCCESS) return;
  if (result == CUFFT_ALLOC_FAILED) {
    cudaGetLastError();
    throw std::bad_alloc();
  }
  throw DeviceFailure(std::string("cuFFT, ") + doing + ": error " + std::to_string(result));
}

CudaQueue::CudaQueue(int device) : device_(device) {
  use();
  check_cuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "creating a stream");
}

CudaQueue::~CudaQueue() {
  cudaSetDevice(device_);
  for (const auto& [size, plan] : plans_) cufftDestroy(plan);
  cudaStreamDestroy(stream_);
}

void CudaQueue::use() { check_cuda(cudaSetDevice(device_), "choosing the device"); }

void* LockedMemory::do_allocate(std::size_t bytes, std::size_t alignment) {
  const std::size_t whole = (std::max<std::size_t>(bytes, 1) + kPage - 1) / kPage * kPage;
  void* memory = std::aligned_alloc(std::max(alignment, kPage), whole);
  if (memory == nullptr) throw std::bad_alloc();
  if (cudaHostRegister(memory, whole, cudaHostRegisterPortable) != cudaSuccess) cudaGetLastError();
  return memory;
}

void LockedMemory::do_deallocate(void* memory, std::size_t, std::size_t) {
  if (cudaHostUnregister(memory) != cudaSuccess) cudaGetLastError();
  std::free(memory);
}

// Never destroyed, because pings may outlive everything else.
std::pmr::memory_resource* CudaQueue::host_memory() {
  static auto* memory = new LockedMemory;
  return memory;
}

void* CudaQueue::allocate(std::size_t bytes) {
  use();
  void* memory = nullptr;
  bytes = std::max<std::size_t>(bytes, 1);
  check_cuda(cudaMalloc(&memory, bytes), "allocating memory");
  bytes_of_.emplace(memory, bytes);
  held_bytes_ += bytes;
  return memory;
}

// Ignores errors, because the call that lost the device has reported them.
void CudaQueue::release(void* memory) {
  if (memory == nullptr) return;
  const auto known = bytes_of_.find(memory);
  held_bytes_ -= known->second;
  bytes_of_.erase(known);
  cudaSetDevice(device_);
  cudaStreamSynchronize(stream_);
  cudaFree(memory);
}

void CudaQueue::upload(void* to, const void* from, std::size_t bytes) {
  use();
  check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream_),
             "copying to the device");
}

void CudaQueue::download(void* to, const void* from, std::size_t bytes) {
  use();
  check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream_),
             "copying from the device");
}

void CudaQueue::zero(void* to, std::size_t bytes) {
  use();
  check_cuda(cudaMemsetAsync(to, 0, bytes, stream_), "clearing memory");
}

cufftHandle CudaQueue::plan(int length, int at_once, int stride) {
  const auto known = plans_.find({length, at_once, stride});
  if (known != plans_.end()) return known->second;
  cufftHandle made = 0;
  const int distance = stride == 1 ? length : 1;
  check_cufft(cufftPlanMany(&made, 1, &length, &length, stride, distance, &length, stride, distance,
                            CUFFT_C2C, at_once),
              "planning a transform");
  plans_.emplace(std::array{length, at_once, stride}, made);
  check_cufft(cufftSetStream(made, stream_), "choosing the stream");
  return made;
}

void CudaQueue::transform_all(cufftHandle plan, Complex32* data, std::int64_t size,
                              std::int64_t count, FftDirection direction) {
  const int sign = direction == FftDirection::forward ? CUFFT_FORWARD : CUFFT_INVERSE;
  for (std::int64_t i = 0; i < count; ++i) {
    auto* one = reinterpret_cast<cufftComplex*>(data + i * size);
    check_cufft(cufftExecC2C(plan, one, one, sign), "transforming");
  }
}

void CudaQueue::transform(Complex32* rows, int length, int at_once, std::int64_t count,
                          FftDirection direction) {
  if (at_once == 0 || count == 0) return;
  use();
  transform_all(plan(length, at_once, 1), rows, std::int64_t{at_once} * length, count, direction);
}

void CudaQueue::transform_columns(Complex32* data, int length, int columns, std::int64_t count,
                                  FftDirection direction) {
  if (columns == 0 || count == 0) return;
  use();
  transform_all(plan(length, columns, columns), data, std::int64_t{columns} * length, count,
                direction);
}

void CudaQueue::wait() {
  use();
  check_cuda(cudaStreamSynchronize(stream_), "waiting for the device");
}

std::size_t CudaQueue::free_bytes() {
  use();
  std::size_t free = 0, total = 0;
  check_cuda(cudaMemGetInfo(&free, &total), "querying free memory");
  return free;
}

}  // namespace ensonify
