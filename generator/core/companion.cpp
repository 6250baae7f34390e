#include "core/companion.h"

#include <system_error>

namespace ensonify {

std::filesystem::path companion_path(const char* name) {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  const auto installed = folder.parent_path() / "lib/ensonify" / name;
  // The program's own folder comes first, so that a build never takes what an older installation
  // left.
  if (std::filesystem::exists(folder / name, error)) return folder / name;
  return std::filesystem::exists(installed, error) ? installed : folder / name;
}

}  // namespace ensonify
