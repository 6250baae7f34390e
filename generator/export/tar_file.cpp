// The entry of the module libensonify_containers.so, and tar files by libarchive.
#include <archive.h>
#include <archive_entry.h>

#include <memory>
#include <utility>

#include "export/file_module.h"

namespace ensonify {
namespace {

struct Freed {
  void operator()(archive* a) const { archive_write_free(a); }
  void operator()(archive_entry* entry) const { archive_entry_free(entry); }
};

class TarWriter final : public TarFile {
 public:
  explicit TarWriter(const std::filesystem::path& path) : archive_(archive_write_new()) {
    archive_write_set_format_ustar(archive_.get());
    is_open_ = archive_write_open_filename(archive_.get(), path.c_str()) == ARCHIVE_OK;
  }

  bool add(const std::string& name, const std::string& bytes) override {
    if (!is_open_) return false;
    const std::unique_ptr<archive_entry, Freed> entry(archive_entry_new());
    archive_entry_set_pathname(entry.get(), name.c_str());
    archive_entry_set_size(entry.get(), static_cast<la_int64_t>(bytes.size()));
    archive_entry_set_filetype(entry.get(), AE_IFREG);
    archive_entry_set_perm(entry.get(), 0644);
    archive_entry_set_mtime(entry.get(), 0, 0);
    return archive_write_header(archive_.get(), entry.get()) == ARCHIVE_OK &&
           std::cmp_equal(archive_write_data(archive_.get(), bytes.data(), bytes.size()),
                          bytes.size());
  }
  bool close() override { return archive_write_close(archive_.get()) == ARCHIVE_OK; }

  int error_number() const override { return archive_errno(archive_.get()); }
  std::string error_text() const override {
    const char* text = archive_error_string(archive_.get());
    return text != nullptr ? text : "";
  }

 private:
  std::unique_ptr<archive, Freed> archive_;
  bool is_open_ = false;
};

constexpr FileModule kModule{new_hdf5_file, new_netcdf_file, new_tar_file};

}  // namespace

TarFile* new_tar_file(const std::filesystem::path& path) { return new TarWriter(path); }

}  // namespace ensonify

extern "C" const ensonify::FileModule* ensonify_containers() { return &ensonify::kModule; }
