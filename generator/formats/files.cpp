#include "formats/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <random>
#include <system_error>
#include <utility>

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 16;

// How often another process may remove .work before that counts as a failure.
constexpr int kAttempts = 20;

std::string reason(int error_number) { return std::generic_category().message(error_number); }

std::string advice(int error_number) {
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
      return "; free some space and run the same command again: finished files are kept";
    case EACCES:
    case EPERM:
    case EROFS:
      return "; make the folder writable or name another one";
    case ENOTDIR:
    case EISDIR:
    case EEXIST:
      return "; something else has its name: move it or name another folder";
    case EMFILE:
    case ENFILE:
      return "; raise the limit of open files (ulimit -n)";
    default:
      return "";
  }
}

std::string number_of_nobody_else() {
  std::random_device random;
  const auto high = static_cast<std::uint64_t>(random()) << 32;
  return fmt::format("{}-{:016x}", ::getpid(), high | random());
}

// Pieces from this size on bypass the page cache, which accepts new files at a fraction of the
// disk's speed.
constexpr std::size_t kDirectBytes = 1 << 20;
constexpr std::size_t kBlock = 4096;
constexpr std::size_t kPiece = 1 << 20;

struct Free {
  void operator()(void* memory) const { std::free(memory); }
};

// False, with errno, where not all is written.
bool write_fully(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const auto written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

struct DirectWrite {
  std::size_t written = 0;  // from the front of `bytes`; the rest is written normally
  int error_number = 0;     // 0, or why a write failed that would also fail normally
};

DirectWrite write_blocks(int descriptor, std::string_view bytes) {
  // The kernel accepts only whole blocks from aligned memory.
  const std::unique_ptr<char, Free> piece(static_cast<char*>(std::aligned_alloc(kBlock, kPiece)));
  DirectWrite done;
  const std::size_t end = bytes.size() / kBlock * kBlock;
  while (piece && done.written < end) {
    const std::size_t size = std::min(kPiece, end - done.written);
    std::memcpy(piece.get(), bytes.data() + done.written, size);
    if (!write_fully(descriptor, {piece.get(), size})) {
      // A file system may accept the flag and refuse the write: normal writing continues from here.
      if (errno != EINVAL) done.error_number = errno;
      break;
    }
    done.written += size;
  }
  return done;
}

// Writes whole blocks directly to the disk, from the descriptor's offset on, which must be a
// multiple of 4096. Writes nothing if the file system does not support this. Leaves the
// descriptor's flags unchanged.
DirectWrite write_past_cache(int descriptor, std::string_view bytes) {
  const int flags = ::fcntl(descriptor, F_GETFL);
  if (flags < 0 || ::fcntl(descriptor, F_SETFL, flags | O_DIRECT) != 0) return {};
  const off_t start = ::lseek(descriptor, 0, SEEK_CUR);
  DirectWrite done;
  if (start >= 0 && static_cast<std::size_t>(start) % kBlock == 0) {
    done = write_blocks(descriptor, bytes);
  }
  ::fcntl(descriptor, F_SETFL, flags);
  // A piece whose write was refused halfway is written again as a whole.
  if (start >= 0) ::lseek(descriptor, start + static_cast<off_t>(done.written), SEEK_SET);
  return done;
}

bool make_folder(const fs::path& folder, int& error_number) {
  if (folder.empty()) return true;
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

Error damaged(const fs::path& path, const std::string& what) {
  return {ErrorKind::io,
          fmt::format("{}: {}; `ensonify verify` lists all damaged files", path.string(), what)};
}

fs::path temporary_beside(const fs::path& path) {
  return path.parent_path() /
         fmt::format(".{}.part-{}", path.filename().string(), number_of_nobody_else());
}

StreamedFile::StreamedFile(const fs::path& dir, std::string relative, bool hashed)
    : path_(dir / relative),
      temporary_folder_(dir / kTemporaryFolder),
      name_(std::move(relative)),
      hashed_(hashed) {
  open_temporary();
}

StreamedFile::StreamedFile(fs::path path) : path_(std::move(path)), name_(path_.string()) {
  open_temporary();
}

StreamedFile::~StreamedFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

bool StreamedFile::open_temporary() {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    temporary_ =
        temporary_folder_ ? *temporary_folder_ / number_of_nobody_else() : temporary_beside(path_);
    if (!make_folder(temporary_.parent_path(), error_number_)) {
      temporary_.clear();
      if (error_number_ == ENOENT) continue;
      return false;
    }
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
  if (bytes.size() >= kDirectBytes) {
    const DirectWrite direct = write_past_cache(descriptor_, bytes);
    if (direct.error_number != 0) {
      error_number_ = direct.error_number;
      return false;
    }
    bytes.remove_prefix(direct.written);
  }
  if (write_fully(descriptor_, bytes)) return true;
  error_number_ = errno;
  return false;
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

void StreamedFile::append_all_of(StreamedFile& other) {
  if (other.error_number_ == 0 && other.write_all(other.buffer_)) other.buffer_.clear();
  error_number_ = error_number_ != 0 ? error_number_ : other.error_number_;
  std::string piece(kBufferBytes, '\0');
  for (off_t offset = 0; error_number_ == 0;) {
    const auto got = ::pread(other.descriptor_, piece.data(), piece.size(), offset);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) error_number_ = errno;
    if (got <= 0) break;
    append({piece.data(), static_cast<std::size_t>(got)});
    offset += got;
  }
}

bool StreamedFile::rename_to_final() {
  if (::rename(temporary_.c_str(), path_.c_str()) == 0) return true;
  error_number_ = errno;
  if (error_number_ != ENOENT) return false;
  if (!make_folder(path_.parent_path(), error_number_)) return false;
  if (::rename(temporary_.c_str(), path_.c_str()) == 0) return true;
  error_number_ = errno;
  return false;
}

// Another process with the same work removed .work with our temporary file in it. The open
// descriptor still has the bytes: copies them to a new temporary file.
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
  const auto failed = [&] { return write_error(path_, error_number_); };
  if (error_number_ != 0 || !write_all(buffer_)) return failed();

  // Network file systems report a full disk when a descriptor is closed; the second descriptor
  // keeps the bytes accessible if the file vanishes.
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
  return FileEntry{name_, bytes_, hashed_ ? hash_.finish() : ""};
}

Status StreamedFile::close() {
  const auto entry = commit();
  return entry ? Status() : Status(entry.error());
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
  return file.close();
}

Result<std::string> read_file(const fs::path& path, std::uint64_t most_bytes) {
  // Does not wait for a writer if the file is a pipe.
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return read_error(path, errno);
  const auto refused = [&](const std::string& why) {
    ::close(file);
    return Error{ErrorKind::io, fmt::format("cannot read {}: {}", path.string(), why)};
  };
  struct stat info {};
  if (::fstat(file, &info) != 0) return refused(reason(errno));
  if (!S_ISREG(info.st_mode)) return refused("not a regular file");
  const auto size = static_cast<std::uint64_t>(info.st_size);
  if (size > most_bytes) return refused(fmt::format("larger than {} bytes", most_bytes));
  // One byte more detects the end; files in /proc report no size.
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

Result<std::string> sha256_of_file(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return read_error(path, errno);
  Sha256 hash;
  std::vector<char> buffer(kBufferBytes);
  for (;;) {
    const auto got = ::read(file, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      const int error_number = errno;
      ::close(file);
      return read_error(path, error_number);
    }
    if (got == 0) break;
    hash.update({buffer.data(), static_cast<std::size_t>(got)});
  }
  ::close(file);
  return hash.finish();
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
    // A file that was removed meanwhile is not an error; the iterator itself reports unreadable
    // folders.
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

}  // namespace ensonify
