#include "dataset/work_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "dataset/layout.h"
#include "dataset/manifest_json.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {
namespace fs = std::filesystem;

FolderLock::FolderLock(const std::filesystem::path& dir)
    : descriptor_(::open(dir.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ >= 0) ::flock(descriptor_, LOCK_EX);
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

FolderUse::FolderUse(const std::filesystem::path& dir)
    : descriptor_(::open((dir / layout::kWorkJson).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW)) {
  if (descriptor_ >= 0) ::flock(descriptor_, LOCK_SH);
}

FolderUse::~FolderUse() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

FolderUse::FolderUse(FolderUse&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

FolderUse& FolderUse::operator=(FolderUse&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

bool FolderUse::is_used(const std::filesystem::path& dir) {
  const int file = ::open((dir / layout::kWorkJson).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0) return false;
  const bool used = ::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(file);
  return used;
}

namespace {

void add_numbers(const fs::path& folder, std::vector<std::uint32_t>& numbers) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.size() < 6 || name.size() > 10) continue;
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const auto number = std::stoull(name);
    if (number <= UINT32_MAX) numbers.push_back(static_cast<std::uint32_t>(number));
  }
}

std::optional<std::string> recorded_failure(const fs::path& dir, std::uint32_t sequence) {
  const std::string path = layout::failure_path(sequence);
  if (!listed_file_size(dir, path)) return std::nullopt;
  const auto text = read_file(dir / path);
  const auto json = text ? parse_json(*text) : std::nullopt;
  if (!json || count_at(*json, "sequence") != sequence) return std::nullopt;
  const Json* error = member(*json, "error");
  if (error == nullptr || !error->is_string()) return std::nullopt;
  return error->get<std::string>();
}

}  // namespace

std::vector<std::uint32_t> sequence_numbers(const fs::path& dir) {
  std::vector<std::uint32_t> numbers;
  add_numbers(dir / "sequences", numbers);
  add_numbers(dir / layout::kWorkFolder / "sequences", numbers);
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

Failures failures_in(const fs::path& dir) {
  Failures failures;
  if (listed_file_size(dir, layout::kDatasetJson)) {
    const auto head = parse_manifest_file(dir / layout::kDatasetJson, [](const FileEntry&) {});
    const auto manifest = head ? read_dataset_head(*head) : std::nullopt;
    if (manifest) {
      for (const auto& [sequence, error] : manifest->failed) failures.emplace(sequence, error);
    }
  }
  std::vector<std::uint32_t> numbers;
  add_numbers(dir / layout::kWorkFolder / "sequences", numbers);
  for (const std::uint32_t sequence : numbers) {
    if (auto error = recorded_failure(dir, sequence)) failures.emplace(sequence, std::move(*error));
  }
  return failures;
}

Status record_failure(const fs::path& dir, const SequenceFailure& failure) {
  const Json json = {{"sequence", failure.sequence}, {"error", failure.error}};
  const auto written =
      write_file_atomically(dir, layout::failure_path(failure.sequence), json_text(json));
  return written ? Status() : Status(written.error());
}

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
