#include "export/file_module.h"

#include "core/runtime.h"

namespace ensonify {

Result<const FileModule*> file_module() {
  static const Result<void*> entry = module_symbol(
      companion_path("libensonify_containers.so"), kFileModuleEntry,
      "install HDF5 and libarchive (Debian: apt-get install libhdf5-dev libarchive-dev)");
  if (!entry) return entry.error();
  return reinterpret_cast<FileModuleEntry>(*entry)();
}

}  // namespace ensonify
