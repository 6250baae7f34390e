// The files of configs/sonars as the build embeds them.
#pragma once

#include <span>

namespace ensonify {

struct PresetFile {
  const char* name;  // of the file, without extension
  const char* text;
};

// Sorted by name. Defined in a source file that scripts/cmake/EmbedFiles.cmake writes.
std::span<const PresetFile> preset_files();

}  // namespace ensonify
