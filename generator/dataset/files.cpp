#include "dataset/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <random>
#include <system_error>
#include <utility>

#include "dataset/direct_write.h"
#include "dataset/layout.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 18;

// How often .work may be taken away under our feet before that counts as a failure.
constexpr int kAttempts = 20;

std::string reason(int error_number) { return std::generic_category().message(error_number); }

std::string advice(int error_number) {
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
      return "; make room and give the same command again: what is finished is kept";
    case EACCES:
    case EPERM:
    case EROFS:
      return "; make the folder writable or name another one";
    case ENOTDIR:
    case EISDIR:
    case EEXIST:
      return "; something else stands in its place: move it or name another folder";
    case EMFILE:
    case ENFILE:
      return "; allow more open files (ulimit -n)";
    default:
      return "";
  }
}

std::string temporary_name() {
  std::random_device random;
  const auto high = static_cast<std::uint64_t>(random()) << 32;
  return fmt::format("{}-{:016x}", ::getpid(), high | random());
}

bool make_folder(const fs::path& folder, int& error_number) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) error_number = error.value();
  return !error;
}

}  // namespace

Error read_error(const fs::path& path, int error_number) {
  return {ErrorKind::io, fmt::format("cannot read {}: {}", path.string(), reason(error_number))};
}

Error write_error(const fs::path& path, int error_number) {
  return {ErrorKind::io, fmt::format("cannot write {}: {}{}", path.string(), reason(error_number),
                                     advice(error_number))};
}

StreamedFile::StreamedFile(fs::path dir, std::string relative, bool hashed)
    : dir_(std::move(dir)), relative_(std::move(relative)), hashed_(hashed) {
  open_temporary();
}

StreamedFile::~StreamedFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

bool StreamedFile::open_temporary() {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (!make_folder(dir_ / layout::kTemporaryFolder, error_number_)) {
      if (error_number_ == ENOENT) continue;
      return false;
    }
    temporary_ = dir_ / layout::kTemporaryFolder / temporary_name();
    descriptor_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ >= 0) {
      error_number_ = 0;
      return true;
    }
    error_number_ = errno;
    temporary_.clear();
    if (error_number_ != ENOENT && error_number_ != EEXIST) return false;
  }
  return false;
}

bool StreamedFile::write_all(std::string_view bytes) {
  // The page cache takes new files at a fraction of the disk's speed.
  if (bytes.size() >= kDirectBytes) {
    const DirectWrite direct = write_past_cache(descriptor_, bytes);
    if (direct.error_number != 0) {
      error_number_ = direct.error_number;
      return false;
    }
    bytes.remove_prefix(direct.written);
  }
  while (!bytes.empty()) {
    const auto written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      error_number_ = errno;
      return false;
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

void StreamedFile::append(std::string_view bytes) {
  if (error_number_ != 0) return;
  bytes_ += bytes.size();
  if (hashed_) hash_.update(bytes);
  if (buffer_.size() + bytes.size() <= kBufferBytes) {
    buffer_ += bytes;
    return;
  }
  if (!write_all(buffer_)) return;
  buffer_.clear();
  if (bytes.size() > kBufferBytes) {
    write_all(bytes);
  } else {
    buffer_ = bytes;
  }
}

bool StreamedFile::rename_to_final() {
  const fs::path final_path = dir_ / relative_;
  if (::rename(temporary_.c_str(), final_path.c_str()) == 0) return true;
  error_number_ = errno;
  if (error_number_ != ENOENT) return false;
  if (!make_folder(final_path.parent_path(), error_number_)) return false;
  if (::rename(temporary_.c_str(), final_path.c_str()) == 0) return true;
  error_number_ = errno;
  return false;
}

// Another copy of the same work has removed .work with our temporary file in it. The bytes live on
// behind the open descriptor: copies them to a new temporary file.
bool StreamedFile::recover_vanished(int source) {
  if (!open_temporary()) return false;
  std::string piece(kBufferBytes, '\0');
  for (off_t offset = 0;;) {
    const auto got = ::pread(source, piece.data(), piece.size(), offset);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) error_number_ = errno;
    if (got <= 0) break;
    if (!write_all({piece.data(), static_cast<std::size_t>(got)})) break;
    offset += got;
  }
  if (::close(std::exchange(descriptor_, -1)) != 0 && error_number_ == 0) error_number_ = errno;
  return error_number_ == 0;
}

Result<FileEntry> StreamedFile::commit() {
  const auto failed = [&] { return write_error(dir_ / relative_, error_number_); };
  if (error_number_ != 0 || !write_all(buffer_)) return failed();

  // Network file systems report a full disk when a descriptor is closed; the second one keeps the
  // bytes within reach should the file vanish.
  const int spare = ::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0);
  if (spare < 0) {
    error_number_ = errno;
    return failed();
  }
  if (::close(std::exchange(descriptor_, -1)) != 0) error_number_ = errno;
  bool renamed = error_number_ == 0 && rename_to_final();
  for (int attempt = 0; !renamed && error_number_ == ENOENT && attempt < kAttempts; ++attempt) {
    renamed = recover_vanished(spare) && rename_to_final();
  }
  ::close(spare);
  if (!renamed) return failed();
  temporary_.clear();
  return FileEntry{relative_, bytes_, hashed_ ? hash_.finish() : ""};
}

Result<FileEntry> write_file_atomically(const fs::path& dir, const std::string& relative,
                                        std::string_view bytes) {
  StreamedFile file(dir, relative);
  file.append(bytes);
  return file.commit();
}

Status write_hashed_file(const fs::path& dir, const std::string& relative, std::string_view bytes) {
  StreamedFile file(dir, relative, false);
  file.append(bytes);
  const auto entry = file.commit();
  return entry ? Status() : Status(entry.error());
}

Result<std::string> read_file(const fs::path& path, std::uint64_t most_bytes) {
  // Not to wait for whoever might write into a pipe.
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return read_error(path, errno);
  const auto refused = [&](const std::string& why) {
    ::close(file);
    return Error{ErrorKind::io, fmt::format("cannot read {}: {}", path.string(), why)};
  };
  struct stat info {};
  if (::fstat(file, &info) != 0) return refused(reason(errno));
  if (!S_ISREG(info.st_mode)) return refused("no regular file");
  const auto size = static_cast<std::uint64_t>(info.st_size);
  if (size > most_bytes) return refused(fmt::format("larger than {} bytes", most_bytes));
  // A byte more shows the end; files of the kernel's own have no size.
  std::string bytes;
  for (std::size_t room = size + 1;; room = kBufferBytes) {
    const std::size_t before = bytes.size();
    bytes.resize(before + room);
    const auto got = ::read(file, bytes.data() + before, room);
    const int error_number = errno;
    bytes.resize(before + (got > 0 ? static_cast<std::size_t>(got) : 0));
    if (got < 0 && error_number == EINTR) continue;
    if (got > 0) continue;
    if (got < 0) return refused(reason(error_number));
    ::close(file);
    return bytes;
  }
}

bool is_safe_relative_path(std::string_view path) {
  if (path.empty() || path.find('\0') != std::string_view::npos) return false;
  for (std::size_t start = 0; start <= path.size();) {
    const std::size_t end = std::min(path.find('/', start), path.size());
    const std::string_view part = path.substr(start, end - start);
    if (part.empty() || part == "." || part == "..") return false;
    start = end + 1;
  }
  return true;
}

std::optional<std::uint64_t> listed_file_size(const fs::path& dir, const std::string& relative) {
  if (!is_safe_relative_path(relative)) return std::nullopt;
  struct stat info {};
  for (auto slash = relative.find('/'); slash != std::string::npos;
       slash = relative.find('/', slash + 1)) {
    if (::lstat((dir / relative.substr(0, slash)).c_str(), &info) != 0) return std::nullopt;
    if (!S_ISDIR(info.st_mode)) return std::nullopt;
  }
  if (::lstat((dir / relative).c_str(), &info) != 0 || !S_ISREG(info.st_mode)) return std::nullopt;
  return static_cast<std::uint64_t>(info.st_size);
}

Result<std::vector<std::string>> files_below(const fs::path& dir) {
  std::vector<std::string> files;
  std::error_code error;
  fs::recursive_directory_iterator entry(dir, error);
  if (error) return read_error(dir, error.value());
  while (entry != fs::recursive_directory_iterator()) {
    const auto status = entry->symlink_status(error);
    // A file that went away meanwhile is no fault; the iterator itself tells of unreadable folders.
    if (!error && !fs::is_directory(status)) {
      files.push_back(entry->path().lexically_relative(dir).generic_string());
    }
    entry.increment(error);
    if (error) return read_error(dir, error.value());
  }
  std::sort(files.begin(), files.end());
  return files;
}

void remove_empty_folders(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(fs::symlink_status(folder, error))) return;
  std::vector<fs::path> folders;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    if (fs::is_directory(entry->symlink_status(ignored))) folders.push_back(entry->path());
  }
  for (const fs::path& inner : folders) remove_empty_folders(inner);
  ::rmdir(folder.c_str());
}

namespace {

bool is_record(const std::string& name) {
  return name.ends_with(".json") || name.ends_with(layout::kMoments);
}

// Those of the folder and below that are ours, by relative name; as they are met, since very many
// pings have very many records.
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
  // A second copy of the same work may still put files there: a few more turns catch most of them,
  // the rest goes when that copy ends or the folder is opened again.
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
  // What is empty goes, which is all where nobody else is at work.
  ::unlink((dir / layout::top_plan_path()).c_str());
  remove_empty_folders(dir / layout::kWorkFolder);
}

}  // namespace ensonify
