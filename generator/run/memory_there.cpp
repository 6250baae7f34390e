#include "run/memory_there.h"

#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kNoLimit = UINT64_MAX;

std::optional<std::uint64_t> number_in(const fs::path& file) {
  std::uint64_t number = 0;
  std::ifstream stream(file);
  if (stream >> number) return number;
  return std::nullopt;  // also for "max"
}

// The value of a key in a table of the kernel.
std::optional<std::uint64_t> bytes_of(const fs::path& table, std::string_view wanted) {
  std::ifstream stream(table);
  for (std::string key; stream >> key; stream.ignore(1 << 10, '\n')) {
    if (std::uint64_t kib = 0; key == wanted && stream >> kib) return kib * 1024;
  }
  return std::nullopt;
}

// The files in which the two kinds of control groups have their numbers.
struct GroupFiles {
  const char *limit, *used;
  // Keys of memory.stat: the memory used for files, and the part of it that is not on the disk yet.
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

// The kernel drops files that are on the disk from memory on demand. Otherwise a group that has
// written much would seem full.
std::uint64_t reclaimable(const fs::path& folder, const GroupFiles& files) {
  std::uint64_t cache = 0, unwritten = 0, bytes = 0;
  std::ifstream stream(folder / "memory.stat");
  for (std::string key; stream >> key >> bytes;) {
    for (const char* name : files.cache) cache += key == name ? bytes : 0;
    for (const char* name : files.unwritten) unwritten += key == name ? bytes : 0;
  }
  return cache - std::min(cache, unwritten);
}

// The tightest limit of a group and all groups around it.
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
  std::uint64_t least = bytes_of(root / "proc/meminfo", "MemAvailable:").value_or(kNoLimit);
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

namespace {

rlim_t soft_limit(__rlimit_resource resource) {
  rlimit limit{};
  return getrlimit(resource, &limit) == 0 ? limit.rlim_cur : RLIM_INFINITY;
}

// What a limit of this process leaves beyond its mapped memory, with the free part of the heap.
std::uint64_t left_of(__rlimit_resource resource, std::string_view mapped) {
  const rlim_t limit = soft_limit(resource);
  const auto used = bytes_of("/proc/self/status", mapped);
  if (limit == RLIM_INFINITY || !used) return kNoLimit;
  return limit - std::min<std::uint64_t>(limit, *used) + mallinfo2().fordblks;
}

}  // namespace

MemoryThere memory_there() {
  MemoryThere there;
  const std::uint64_t swap = bytes_of("/proc/meminfo", "SwapFree:").value_or(0);
  there.bytes = available_memory();
  there.bytes += std::min(swap, kNoLimit - there.bytes);
  const rlim_t stack = soft_limit(RLIMIT_STACK);
  const std::uint64_t per_thread = stack == RLIM_INFINITY ? 0 : stack;
  const std::uint64_t data = left_of(RLIMIT_DATA, "VmData:");
  if (data < there.bytes) there = {data, " (ulimit -d)", per_thread};
  const std::uint64_t space = left_of(RLIMIT_AS, "VmSize:");
  if (space < there.bytes) there = {space, " (ulimit -v)", per_thread};
  return there;
}

}  // namespace ensonify
