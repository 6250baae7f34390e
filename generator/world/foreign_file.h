// Files that other libraries read (assimp, OpenVDB) are read by a process of their own,
// `ensonify_import`, with limits of memory and time: a file that crashes it, hangs it or swells in
// it is refused like any other wrong input.
//
//   ImportLimits  import_limits   what reading a file may take
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

// 2 GB and 64 bytes for each of the file; a minute and a second for each megabyte: more than ten
// times what an honest file was seen to take.
ImportLimits import_limits(std::uint64_t file_bytes);

// The importer's executable: what the environment's ENSONIFY_IMPORTER names, as ctest does for test
// programs, else `ensonify_import` by companion_path. No other folder is searched: in one that
// anybody can write to, such as /tmp, another user could have put a file of this name there.
std::filesystem::path importer_path();

struct ImportRequest {
  std::filesystem::path importer, file;
  std::vector<std::string> words;  // the kind, the file and four more
  ImportLimits limits;
};

// Hands what the importer writes to `read`. Errors: those of `read`; usage, naming the file, where
// the importer crashed, took too long or too much, or gave nonsense; io where it cannot be started.
Status run_import(const ImportRequest& request,
                  const std::function<Status(const WireInput&)>& read);

}  // namespace ensonify
