// Files that HDF5 and libarchive write. They are in a module, libensonify_containers.so, since
// these libraries bring Kerberos, LDAP and XML, which no other command needs. Private to export/.
//
//   TarFile                     a tar file, written from its first byte to its last
//   FileModule  file_module     opens each kind of file; from the module
//   FileModuleEntry  kFileModuleEntry     the module's function
#pragma once

#include <filesystem>
#include <string>

#include "core/error.h"
#include "export/hdf5_file.h"
#include "export/netcdf_file.h"

namespace ensonify {

class TarFile {
 public:
  TarFile() = default;
  virtual ~TarFile() = default;
  TarFile(const TarFile&) = delete;
  TarFile& operator=(const TarFile&) = delete;

  // A file of mode 0644 without a time.
  virtual bool add(const std::string& name, const std::string& bytes) = 0;
  virtual bool close() = 0;
  // After one of them failed: the system's number, or a text if it is 0.
  virtual int error_number() const = 0;
  virtual std::string error_text() const = 0;
};

// Paths must not exist; a tar file is replaced. The caller deletes what is opened. A failure to
// open is that of the first write.
struct FileModule {
  Hdf5File* (*hdf5)(const std::filesystem::path& path);
  NetcdfFile* (*netcdf)(const std::filesystem::path& path);
  TarFile* (*tar)(const std::filesystem::path& path);
};

// Error (device): the module cannot be opened.
Result<const FileModule*> file_module();

using FileModuleEntry = const FileModule* (*)();
inline constexpr char kFileModuleEntry[] = "ensonify_containers";

// In the module.
Hdf5File* new_hdf5_file(const std::filesystem::path& path);
NetcdfFile* new_netcdf_file(const std::filesystem::path& path);
TarFile* new_tar_file(const std::filesystem::path& path);

}  // namespace ensonify
