// Host memory that a device writes its results into and pings then own.
//
//   ResultPool
#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <memory_resource>
#include <mutex>
#include <new>
#include <utility>

namespace ensonify {

// Blocks return when their ping goes, in any thread, also after the backend is gone, and serve the
// next pings: memory that a device can copy to fast takes milliseconds to get. May be used by
// several threads at once.
class ResultPool final : public std::pmr::memory_resource {
 public:
  // `source` outlives all pools.
  explicit ResultPool(std::pmr::memory_resource* source) : source_(source) {}
  ~ResultPool() override {
    for (const auto& [bytes, block] : idle_) source_->deallocate(block, bytes, kAlignment);
  }

  // Blocks that return are kept up to this size in all, so that a user who holds many pings and
  // drops them leaves no more here. Further calls can only raise it.
  void keep(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    most_idle_ = std::max(most_idle_, bytes);
  }

 private:
  static constexpr std::size_t kAlignment = 64;

  void* do_allocate(std::size_t bytes, std::size_t /*alignment*/) override {
    {
      const std::lock_guard lock(mutex_);
      if (auto found = idle_.extract(bytes)) {
        idle_bytes_ -= bytes;
        return found.mapped();
      }
    }
    return source_->allocate(bytes, kAlignment);
  }
  void do_deallocate(void* block, std::size_t bytes, std::size_t /*alignment*/) override {
    if (!kept(bytes, block)) source_->deallocate(block, bytes, kAlignment);
  }
  bool kept(std::size_t bytes, void* block) {
    const std::lock_guard lock(mutex_);
    if (idle_bytes_ + bytes > most_idle_) return false;
    try {
      idle_.emplace(bytes, block);
    } catch (const std::bad_alloc&) {
      return false;
    }
    idle_bytes_ += bytes;
    return true;
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  std::pmr::memory_resource* source_;
  std::mutex mutex_;
  std::multimap<std::size_t, void*> idle_;  // by size
  std::size_t idle_bytes_ = 0, most_idle_ = 0;
};

}  // namespace ensonify
