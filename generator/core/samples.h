// Arrays whose memory may belong to the backend of a device, so that what the device writes reaches
// images and files without a copy.
//
//   SampleAllocator
//   SampleArray  Series
#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <memory_resource>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace ensonify {

// Ordinary memory, or memory of `source`, which then lives as long as any of its memory. Memory
// moves with its values; a copy has ordinary memory.
template <class T>
class SampleAllocator {
 public:
  using value_type = T;
  using propagate_on_container_move_assignment = std::true_type;
  using propagate_on_container_swap = std::true_type;

  SampleAllocator() = default;
  explicit SampleAllocator(std::shared_ptr<std::pmr::memory_resource> source)
      : source_(std::move(source)) {}
  template <class U>
  SampleAllocator(const SampleAllocator<U>& other) : source_(other.source()) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    return static_cast<T*>(source_ ? source_->allocate(bytes, alignof(T)) : ::operator new(bytes));
  }
  void deallocate(T* values, std::size_t count) {
    if (source_) {
      source_->deallocate(values, count * sizeof(T), alignof(T));
    } else {
      ::operator delete(values);
    }
  }

  // Called for values that a vector adds without being given any. Those in memory of `source` stay
  // as they are, because a device writes them.
  template <class U>
  void construct(U* value) {
    if (!source_) ::new (static_cast<void*>(value)) U();
  }
  SampleAllocator select_on_container_copy_construction() const { return {}; }

  const std::shared_ptr<std::pmr::memory_resource>& source() const { return source_; }
  friend bool operator==(const SampleAllocator& a, const SampleAllocator& b) {
    return a.source_ == b.source_;
  }

 private:
  std::shared_ptr<std::pmr::memory_resource> source_;
};

template <class T>
using SampleArray = std::vector<T, SampleAllocator<T>>;

using Series = SampleArray<std::complex<float>>;

}  // namespace ensonify
