// Memory that runs side by side share: who does not fit waits.
//
//   available_memory   what this process may still take of the machine
//   MemoryGate         hold
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <utility>

namespace ensonify {

// What the kernel says is available, or less where control groups (of a batch system, of a
// container) leave less. `root` is where /proc and /sys stand. Without limits where neither tells.
std::uint64_t available_memory(const std::filesystem::path& root = "/");

class MemoryGate {
 public:
  explicit MemoryGate(std::uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  enum class What { world, run };

  // Held until it is destroyed or assigned to.
  class Hold {
   public:
    Hold() = default;
    Hold(Hold&& other) noexcept { *this = std::move(other); }
    Hold& operator=(Hold&& other) noexcept;
    ~Hold() { release(); }

   private:
    friend class MemoryGate;
    void release();
    MemoryGate* gate_ = nullptr;
    What what_ = What::run;
    std::uint64_t bytes_ = 0;
  };

  // Waits until it fits. A run that fits nowhere goes when no other run is held, a world when
  // nothing is: the budget bounds how many there are at once, not what one may take.
  Hold hold(What what, std::uint64_t bytes);

  // Corrects what is held, without waiting.
  void resize(Hold& hold, std::uint64_t bytes);

  // Whether it would not have to wait, were all of `runs` as large.
  bool fits(std::uint64_t bytes, std::uint64_t runs) const;

 private:
  std::uint64_t budget_bytes_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t held_bytes_ = 0;
  std::size_t held_ = 0, runs_ = 0;
};

}  // namespace ensonify
