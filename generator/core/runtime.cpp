#include "core/runtime.h"

#include <dlfcn.h>

#include <cstdlib>
#include <system_error>

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kNames[] = {"sse4", "avx2", "avx512"};

// The program, or the Python module that contains this code.
fs::path own_file() {
  std::error_code error;
  Dl_info info;
  if (dladdr(reinterpret_cast<const void*>(&own_file), &info) != 0 && info.dli_fname != nullptr) {
    const fs::path file = fs::canonical(info.dli_fname, error);
    if (!error && file.extension() == ".so") return file;
  }
  return fs::read_symlink("/proc/self/exe", error);
}

}  // namespace

std::filesystem::path companion_path(const char* name) {
  if (const char* given = std::getenv("ENSONIFY_COMPANIONS")) return fs::path(given) / name;
  std::error_code error;
  const fs::path folder = own_file().parent_path();
  // The program's own folder comes first, so that a build never uses files of an older
  // installation.
  for (const char* place : {"", "../lib/ensonify", "../../../ensonify"}) {
    const fs::path file = (folder / place / name).lexically_normal();
    if (fs::exists(file, error)) return file;
  }
  return folder / name;
}

Result<void*> module_symbol(const fs::path& module, const char* symbol, const std::string& advice) {
  const auto failed = [](const std::string& trouble) { return Error{ErrorKind::device, trouble}; };
  if (!fs::exists(module)) {
    return failed("there is no " + module.string() +
                  ", a part of ensonify; build or install ensonify again");
  }
  void* opened = dlopen(module.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (opened == nullptr) return failed(std::string(dlerror()) + "; " + advice);
  void* found = dlsym(opened, symbol);
  if (found == nullptr)
    return failed(module.string() +
                  " is not a module of this program; build or install ensonify again");
  return found;
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
