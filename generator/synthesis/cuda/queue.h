// What a device program asks of a device. Two classes offer it: CudaQueue, and HostQueue of the
// tests, which runs the same functors in a loop.
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
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace ensonify {

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
