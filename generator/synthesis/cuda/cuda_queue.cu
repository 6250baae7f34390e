#include "synthesis/cuda/cuda_queue.cuh"

#include <algorithm>
#include <new>

namespace ensonify {
namespace {

// Batches are of few sizes; the work area of a plan is as large as its data.
constexpr std::size_t kMostPlans = 16;

}  // namespace

void check_cuda(cudaError_t error, const char* doing) {
  if (error == cudaSuccess) return;
  if (error == cudaErrorMemoryAllocation) {
    cudaGetLastError();  // or the next call would report it again
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

void* CudaQueue::allocate(std::size_t bytes) {
  use();
  void* memory = nullptr;
  check_cuda(cudaMalloc(&memory, std::max<std::size_t>(bytes, 1)), "allocating memory");
  return memory;
}

// Errors of a lost device were told by the call that met it.
void CudaQueue::release(void* memory) {
  if (memory == nullptr) return;
  cudaSetDevice(device_);
  cudaStreamSynchronize(stream_);
  cudaFree(memory);
}

void CudaQueue::upload(void* to, const void* from, std::size_t bytes) {
  use();
  check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream_), "copying up");
}

void CudaQueue::download(void* to, const void* from, std::size_t bytes) {
  use();
  check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream_), "copying down");
  wait();
}

void CudaQueue::zero(void* to, std::size_t bytes) {
  use();
  check_cuda(cudaMemsetAsync(to, 0, bytes, stream_), "clearing memory");
}

void CudaQueue::transform(Complex32* rows, int length, int count, FftDirection direction) {
  if (count == 0) return;
  use();
  auto plan = plans_.find({length, count});
  if (plan == plans_.end()) {
    if (plans_.size() >= kMostPlans) {
      wait();
      for (const auto& [size, old] : plans_) cufftDestroy(old);
      plans_.clear();
    }
    cufftHandle made = 0;
    check_cufft(
        cufftPlanMany(&made, 1, &length, nullptr, 1, length, nullptr, 1, length, CUFFT_C2C, count),
        "planning a transform");
    plan = plans_.emplace(std::pair(length, count), made).first;
    check_cufft(cufftSetStream(made, stream_), "choosing the stream");
  }
  auto* data = reinterpret_cast<cufftComplex*>(rows);
  const int sign = direction == FftDirection::forward ? CUFFT_FORWARD : CUFFT_INVERSE;
  check_cufft(cufftExecC2C(plan->second, data, data, sign), "transforming");
}

void CudaQueue::wait() {
  use();
  check_cuda(cudaStreamSynchronize(stream_), "waiting for the device");
}

std::size_t CudaQueue::free_bytes() {
  use();
  std::size_t free = 0, total = 0;
  check_cuda(cudaMemGetInfo(&free, &total), "asking for free memory");
  return free;
}

}  // namespace ensonify
