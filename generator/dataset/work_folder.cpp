#include "dataset/work_folder.h"

#include <unistd.h>

#include <string>
#include <system_error>

#include "dataset/layout.h"
#include "formats/files.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

bool is_record(const std::string& name) {
  return name.ends_with(".json") || name.ends_with(layout::kMoments);
}

// Calls back for our files in the folder and below, by relative name, as they are found, since many
// pings have many records.
template <class Ours>
void remove_files(const fs::path& folder, Ours ours) {
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error);
  while (!error && entry != fs::recursive_directory_iterator()) {
    std::error_code ignored;
    const bool is_folder = fs::is_directory(entry->symlink_status(ignored));
    const std::string name = entry->path().lexically_relative(folder).generic_string();
    if (!is_folder && ours(name)) ::unlink(entry->path().c_str());
    entry.increment(error);
  }
}

}  // namespace

void remove_work_folder(const fs::path& dir) {
  const fs::path work = dir / layout::kWorkFolder;
  std::error_code error;
  if (!fs::is_directory(fs::symlink_status(work, error))) return;
  // Another process with the same work may still write files there: a few more passes catch most of
  // them; the rest is removed when that process ends or the folder is opened again.
  for (int attempt = 0; attempt < 3 && fs::exists(work, error); ++attempt) {
    remove_files(work, [](const std::string& name) {
      const bool record = name.starts_with("sequences/") && is_record(name);
      return record || name.starts_with("tmp/") || name == "plan.json";
    });
    remove_empty_folders(work);
  }
}

void remove_temporary_files(const fs::path& dir) {
  const fs::path folder = dir / layout::kTemporaryFolder;
  std::error_code error;
  if (fs::is_directory(fs::symlink_status(folder, error))) {
    remove_files(folder, [](const std::string&) { return true; });
  }
}

void remove_work_of(const fs::path& dir, std::span<const std::uint32_t> sequences) {
  for (const std::uint32_t sequence : sequences) {
    const fs::path folder = (dir / layout::plan_path(sequence)).parent_path();
    std::error_code error;
    if (!fs::is_directory(fs::symlink_status(folder, error))) continue;
    remove_files(folder, is_record);
  }
  // Removes empty folders, which are all unless another process works here.
  ::unlink((dir / layout::top_plan_path()).c_str());
  remove_empty_folders(dir / layout::kWorkFolder);
}

}  // namespace ensonify
