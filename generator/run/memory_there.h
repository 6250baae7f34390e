// The memory that is there for this process.
//
//   available_memory            what the machine and control groups leave
//   MemoryThere  memory_there   ... and swap and the limits of the process
#pragma once

#include <cstdint>
#include <filesystem>

namespace ensonify {

// The memory that the kernel reports as available, or less if control groups (of a batch system or
// a container) allow less. `root` is the parent of /proc and /sys. Unlimited if neither reports a
// number.
std::uint64_t available_memory(const std::filesystem::path& root = "/");

// What may still be taken: the least of available_memory with free swap, and of the limits of data
// and address space.
struct MemoryThere {
  std::uint64_t bytes = 0;
  const char* limit = "";              // " (ulimit -v)"; empty: the machine or its control group
  std::uint64_t bytes_per_thread = 0;  // stacks, which only the limits of the process count
};
MemoryThere memory_there();

}  // namespace ensonify
