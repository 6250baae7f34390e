#include "report/page_output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <random>
#include <utility>

#include "dataset/files.h"
#include "report/page_text.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

Error refused(const fs::path& path, const std::string& what) {
  return {ErrorKind::usage, path.string() + ": " + what};
}

// The folder as it was called, unless that says nothing: then by its own name.
fs::path named(const fs::path& folder) {
  fs::path plain = folder.lexically_normal();
  if (!plain.has_filename()) plain = plain.parent_path();
  const fs::path name = plain.filename();
  return name.empty() || name == "." || name == ".." ? fs::weakly_canonical(folder) : plain;
}

bool lies_in(const fs::path& inner, const fs::path& outer) {
  const fs::path a = fs::weakly_canonical(inner), b = fs::weakly_canonical(outer);
  return std::mismatch(b.begin(), b.end(), a.begin(), a.end()).first == b.end();
}

bool is_page(const fs::path& path) {
  std::string head(kPageMark.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  return file.gcount() == static_cast<std::streamsize>(head.size()) && head == kPageMark;
}

}  // namespace

Result<PageOutput> PageOutput::open(const fs::path& output, const fs::path& dataset,
                                    bool overwrite) {
  const fs::path folder = named(dataset);
  const fs::path path = output.empty()
                            ? folder.parent_path() / (folder.filename().string() + "_report.html")
                            : output.lexically_normal();
  std::error_code error;
  if (!path.has_filename() || fs::is_directory(path, error)) {
    return refused(path, "is a folder; name the file to write");
  }
  if (lies_in(path, folder)) {
    return refused(path,
                   "lies in the data set, where `ensonify verify` would find a file that no "
                   "manifest lists; name a place outside of it");
  }
  const auto there = fs::status(path, error);
  if (fs::exists(there) && !overwrite) {
    if (!fs::is_regular_file(there) || !is_page(path)) {
      return refused(path,
                     "is there already and no page of ensonify; name another file, or give "
                     "--overwrite to replace it");
    }
  }
  return PageOutput(path);
}

PageOutput::PageOutput(PageOutput&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})),
      descriptor_(std::exchange(other.descriptor_, -1)),
      error_number_(other.error_number_),
      bytes_(other.bytes_) {}

PageOutput::~PageOutput() {
  if (descriptor_ >= 0) ::close(descriptor_);
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove(temporary_, ignored);
}

void PageOutput::append(std::string_view bytes) {
  if (temporary_.empty()) {
    std::error_code ignored;
    // Where this fails open() tells.
    if (path_.has_parent_path()) fs::create_directories(path_.parent_path(), ignored);
    std::random_device random;
    temporary_ =
        path_.parent_path() / fmt::format(".{}.part-{:08x}", path_.filename().string(), random());
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) error_number_ = errno;
  }
  bytes_ += bytes.size();
  while (error_number_ == 0 && !bytes.empty()) {
    const auto written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR) error_number_ = errno;
    if (written > 0) bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

Status PageOutput::commit() {
  if (descriptor_ >= 0 && ::close(std::exchange(descriptor_, -1)) != 0 && error_number_ == 0) {
    error_number_ = errno;
  }
  if (error_number_ == 0 && ::rename(temporary_.c_str(), path_.c_str()) != 0) {
    error_number_ = errno;
  }
  if (error_number_ != 0) return write_error(path_, error_number_);
  temporary_.clear();
  return {};
}

}  // namespace ensonify
