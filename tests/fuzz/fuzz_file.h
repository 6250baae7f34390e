// The input as a file, for readers that take a path. Under $TMPDIR, which fuzz.sh puts into memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "scenario/faults.h"
#include "temporary_folder.h"

namespace ensonify::test {

inline const std::filesystem::path& fuzz_folder() {
  static const TemporaryFolder folder;
  return folder.path();
}

inline std::filesystem::path fuzz_file(const std::string& name, std::string_view bytes) {
  const std::filesystem::path path = fuzz_folder() / name;
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path;
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// Inputs that stay under a second under sanitizers, which libFuzzer is given as a hang.
inline constexpr ReadLimits kFuzzLimits{10'000, 5'000, 5'000};

// Counts inputs that were read to the end. Told when the run is over: a fuzzer that gets nowhere
// behind the first check finds nothing there.
inline void accepted() {
  static struct Count {
    unsigned long long inputs = 0;
    ~Count() { std::fprintf(stderr, "accepted: %llu\n", inputs); }
  } count;
  ++count.inputs;
}

// A broken promise ends the process, as libFuzzer wants it.
inline void promise(bool kept) {
  if (!kept) __builtin_trap();
}

}  // namespace ensonify::test
