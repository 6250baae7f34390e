#include "core/runtime.h"

#include <system_error>

namespace ensonify {
namespace {

constexpr std::string_view kNames[] = {"sse4", "avx2", "avx512"};

}  // namespace

std::filesystem::path companion_path(const char* name) {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  const auto installed = folder.parent_path() / "lib/ensonify" / name;
  // The program's own folder comes first, so that a build never takes what an older installation
  // left.
  if (std::filesystem::exists(folder / name, error)) return folder / name;
  return std::filesystem::exists(installed, error) ? installed : folder / name;
}

SimdLevel best_simd_level() {
#if defined(__x86_64__)
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512vl");
  if (avx512) return SimdLevel::avx512;
  if (avx2) return SimdLevel::avx2;
#endif
  return SimdLevel::sse4;
}

std::string_view simd_level_name(SimdLevel level) { return kNames[static_cast<int>(level)]; }

std::optional<SimdLevel> parse_simd_level(std::string_view name) {
  for (const SimdLevel level : {SimdLevel::sse4, SimdLevel::avx2, SimdLevel::avx512}) {
    if (name == simd_level_name(level)) return level;
  }
  return std::nullopt;
}

}  // namespace ensonify
