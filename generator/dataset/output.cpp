#include "dataset/output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <random>
#include <system_error>
#include <utility>

#include "dataset/files.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 18;

Error refused(const fs::path& out, const std::string& what) {
  return {ErrorKind::usage, out.string() + ": " + what};
}

// Whether `inner` is `outer` or lies in it, links resolved as far as there is something.
bool lies_in(const fs::path& inner, const fs::path& outer) {
  const fs::path a = fs::weakly_canonical(inner), b = fs::weakly_canonical(outer);
  const auto [rest, other] = std::mismatch(b.begin(), b.end(), a.begin(), a.end());
  return rest == b.end();
}

std::string temporary_name(const fs::path& name) {
  std::random_device random;
  return fmt::format(".{}.part-{}-{:08x}", name.string(), ::getpid(), random());
}

}  // namespace

OutputPlace::OutputPlace(fs::path out, fs::path temporary)
    : out_(std::move(out)), temporary_(std::move(temporary)) {}

OutputPlace::OutputPlace(OutputPlace&& other) noexcept
    : out_(std::move(other.out_)), temporary_(std::move(other.temporary_)) {
  other.temporary_.clear();
}

OutputPlace::~OutputPlace() {
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
}

Result<OutputPlace> OutputPlace::open(const fs::path& given, bool is_folder,
                                      const fs::path& dataset, bool replace) {
  fs::path out = given.empty() ? given : fs::absolute(given).lexically_normal();
  if (!given.empty() && !out.has_filename()) out = out.parent_path();
  if (!out.has_filename()) {
    return refused(given, "accepted is the name of a file or folder to write");
  }
  if (lies_in(out, dataset)) return refused(out, "lies in the data set; name another place");
  std::error_code error;
  const auto there = fs::symlink_status(out, error);
  if (fs::exists(there)) {
    const bool empty_folder = fs::is_directory(there) && fs::is_empty(out, error) && !error;
    if (!is_folder && !replace) {
      return refused(out, "is there already; remove it or name another file");
    }
    if (!is_folder && !fs::is_regular_file(there)) {
      return refused(out, "is there already and no file; name another");
    }
    if (is_folder && !empty_folder) {
      return refused(out, "is not empty; empty it or name another folder");
    }
  }
  const fs::path parent = out.parent_path();
  fs::create_directories(parent, error);
  if (error) return write_error(parent, error.value());
  OutputPlace place(out, parent / temporary_name(out.filename()));
  if (is_folder) {
    fs::create_directory(place.temporary_, error);
    if (error) return write_error(out, error.value());
  }
  return place;
}

Status OutputPlace::commit() {
  if (::rename(temporary_.c_str(), out_.c_str()) != 0) return write_error(out_, errno);
  temporary_.clear();
  return {};
}

OutputFile::OutputFile(fs::path path) : path_(std::move(path)) {
  std::error_code error;
  fs::create_directories(path_.parent_path(), error);
  if (error) {
    error_number_ = error.value();
    return;
  }
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor_ < 0) error_number_ = errno;
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutputFile::flush() {
  std::string_view rest = buffer_;
  while (error_number_ == 0 && !rest.empty()) {
    const auto written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) error_number_ = errno;
    if (written > 0) rest.remove_prefix(static_cast<std::size_t>(written));
  }
  buffer_.clear();
}

void OutputFile::append(std::string_view bytes) {
  bytes_ += bytes.size();
  buffer_ += bytes;
  if (buffer_.size() >= kBufferBytes) flush();
}

Status OutputFile::close() {
  flush();
  if (descriptor_ >= 0 && ::close(std::exchange(descriptor_, -1)) != 0 && error_number_ == 0) {
    error_number_ = errno;
  }
  return error_number_ == 0 ? Status() : Status(write_error(path_, error_number_));
}

Status write_whole(const fs::path& path, std::string_view bytes) {
  OutputFile file(path);
  file.append(bytes);
  return file.close();
}

Status copy_whole(const fs::path& from, const fs::path& to) {
  const auto bytes = read_file(from);
  return bytes ? write_whole(to, *bytes) : Status(bytes.error());
}

}  // namespace ensonify
