// The files of report/page as the build embeds them.
#pragma once

#include <span>

namespace ensonify {

struct PageFile {
  const char* name;  // of the file, without extension
  const char* text;
};

// Sorted by name. Defined in a source that scripts/cmake/EmbedFiles.cmake writes.
std::span<const PageFile> page_files();

}  // namespace ensonify
