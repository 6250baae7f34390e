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

// Where the two kinds of control groups have their numbers.
struct GroupFiles {
  const char *limit, *used;
  // Of memory.stat: what files take of the memory in use, and what of it is not on the disk yet.
  const char *cache[2], *unwritten[2];
};
constexpr GroupFiles kSecondKind = {"memory.max",
                                    "memory.current",
                                    {"active_file", "inactive_file"},
                                    {"file_dirty", "file_writeback"}};
constexpr GroupFiles kFirstKind = {"memory.limit_in_bytes",
                                   "memory.usage_in_bytes",
                                   {"total_active_file", "total_inactive_file"},
                                   {"total_dirty", "total_writeback"}};

// The kernel takes files that are on the disk out of memory when it is needed: a group that has
// written much would otherwise seem full.
std::uint64_t reclaimable(const fs::path& folder, const GroupFiles& files) {
  std::uint64_t cache = 0, unwritten = 0, bytes = 0;
  std::ifstream stream(folder / "memory.stat");
  for (std::string key; stream >> key >> bytes;) {
    for (const char* name : files.cache) cache += key == name ? bytes : 0;
    for (const char* name : files.unwritten) unwritten += key == name ? bytes : 0;
  }
  return cache - std::min(cache, unwritten);
}

// The tightest of a group and all groups around it.
std::uint64_t of_groups(const fs::path& top, const std::string& group, const GroupFiles& files) {
  std::uint64_t least = kNoLimit;
  fs::path folder = top / fs::path(group).relative_path();
  for (;; folder = folder.parent_path()) {
    const auto limit = number_in(folder / files.limit);
    const auto usage = number_in(folder / files.used);
    if (limit && usage) {
      const std::uint64_t used = *usage - std::min(*usage, reclaimable(folder, files));
      least = std::min(least, *limit - std::min(*limit, used));
    }
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
      least = std::min(least, of_groups(top, group, kSecondKind));
    } else if (kinds.find("memory") != std::string::npos) {
      least = std::min(least, of_groups(top / "memory", group, kFirstKind));
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
