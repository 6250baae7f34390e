// Untrusted files that other libraries read (assimp, OpenVDB) are read in a separate process,
// `ensonify_import`, with limits on memory and time: a file that crashes or hangs it, or needs too
// much memory, is refused like any other invalid input.
//
//   ImportLimits  import_limits   limits for reading a file
//   ImportRequest run_import      for the loaders of mesh.h and density.h
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/error.h"
#include "world/import/wire.h"

namespace ensonify {

struct ImportLimits {
  std::uint64_t memory_bytes = 0;  // of addresses
  std::uint64_t seconds = 0;       // of processor time; four times as many by the clock
};

// 2 GB plus 64 bytes per byte of the file, and a minute plus a second per megabyte. Valid files
// needed less than a tenth of this.
ImportLimits import_limits(std::uint64_t file_bytes);

// The importer's executable: `ensonify_import` by companion_path. No other folder is searched,
// because another user could have put a file of this name into a world-writable one, such as /tmp.
std::filesystem::path importer_path();

struct ImportRequest {
  std::filesystem::path importer, file;
  std::vector<std::string> words;  // the kind, the file and four other words
  ImportLimits limits;
};

// Passes the importer's output to `read`. Errors: those of `read`; usage, naming the file, if the
// importer crashed, exceeded a limit or wrote nonsense; io if it cannot be started.
Status run_import(const ImportRequest& request,
                  const std::function<Status(const WireInput&)>& read);

}  // namespace ensonify
