#include "app/memory_gate.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <string>

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kNoLimit = UINT64_MAX;

std::optional<std::uint64_t> number_in(const fs::path& file) {
  std::uint64_t number = 0;
  std::ifstream stream(file);
  if (stream >> number) return number;
  return std::nullopt;  // "max" too
}

std::uint64_t of_kernel(const fs::path& root) {
  std::ifstream info(root / "proc/meminfo");
  for (std::string key; info >> key; info.ignore(1 << 10, '\n')) {
    if (std::uint64_t kib = 0; key == "MemAvailable:" && info >> kib) return kib * 1024;
  }
  return kNoLimit;
}

// The tightest of a group and all groups around it.
std::uint64_t of_groups(const fs::path& top, const std::string& group, const char* limit_file,
                        const char* used_file) {
  std::uint64_t least = kNoLimit;
  fs::path folder = top / fs::path(group).relative_path();
  for (;; folder = folder.parent_path()) {
    const auto limit = number_in(folder / limit_file);
    const auto used = number_in(folder / used_file);
    if (limit && used) least = std::min(least, *limit - std::min(*limit, *used));
    if (folder == top || folder == folder.parent_path()) return least;
  }
}

}  // namespace

std::uint64_t available_memory(const fs::path& root) {
  std::uint64_t least = of_kernel(root);
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string kinds = line.substr(first + 1, second - first - 1);
    const std::string group = line.substr(second + 1);
    const fs::path top = root / "sys/fs/cgroup";
    if (kinds.empty()) {
      least = std::min(least, of_groups(top, group, "memory.max", "memory.current"));
    } else if (kinds.find("memory") != std::string::npos) {
      least = std::min(least, of_groups(top / "memory", group, "memory.limit_in_bytes",
                                        "memory.usage_in_bytes"));
    }
  }
  return least;
}

MemoryGate::Hold& MemoryGate::Hold::operator=(Hold&& other) noexcept {
  if (this == &other) return *this;
  release();
  gate_ = std::exchange(other.gate_, nullptr);
  what_ = other.what_;
  bytes_ = other.bytes_;
  return *this;
}

void MemoryGate::Hold::release() {
  if (gate_ == nullptr) return;
  const std::lock_guard lock(gate_->mutex_);
  gate_->held_bytes_ -= bytes_;
  --gate_->held_;
  if (what_ == What::run) --gate_->runs_;
  gate_->changed_.notify_all();
  gate_ = nullptr;
}

MemoryGate::Hold MemoryGate::hold(What what, std::uint64_t bytes) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] {
    const bool fits = held_bytes_ <= budget_bytes_ && bytes <= budget_bytes_ - held_bytes_;
    return fits || (what == What::run ? runs_ : held_) == 0;
  });
  Hold hold;
  hold.gate_ = this;
  hold.what_ = what;
  hold.bytes_ = bytes;
  held_bytes_ += bytes;
  ++held_;
  if (what == What::run) ++runs_;
  return hold;
}

void MemoryGate::resize(Hold& hold, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  held_bytes_ += bytes - hold.bytes_;
  hold.bytes_ = bytes;
  changed_.notify_all();
}

bool MemoryGate::fits(std::uint64_t bytes, std::uint64_t runs) const {
  return bytes <= budget_bytes_ / runs;
}

}  // namespace ensonify
