// The files of output_schema that verify needs, as the build embeds them.
#pragma once

#include <span>

namespace ensonify {

struct SchemaFile {
  const char* name;  // of the file, without .json
  const char* text;
};

// Sorted by name. Defined in a source that scripts/cmake/EmbedFiles.cmake writes.
std::span<const SchemaFile> schema_files();

}  // namespace ensonify
