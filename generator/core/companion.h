// Files that belong to the program and are started or opened by it: the importer, the CUDA module.
//
//   companion_path   where such a file is
#pragma once

#include <filesystem>

namespace ensonify {

// The file of this name in the program's own folder, as in a build tree, or in ../lib/ensonify,
// where an installation puts it. Where neither exists: the path in the program's own folder.
std::filesystem::path companion_path(const char* name);

}  // namespace ensonify
