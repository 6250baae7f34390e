// The files of configs as the build embeds them.
#pragma once

#include <span>

namespace ensonify {

struct PresetFile {
  const char* name;  // of the file, without extension
  const char* text;
};

// Sorted by name. Defined in a source file that scripts/cmake/EmbedFiles.cmake writes.
std::span<const PresetFile> preset_files();
// configs/materials.yaml alone.
std::span<const PresetFile> material_files();

}  // namespace ensonify
