#include "formats/output_place.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include "formats/files.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

Error refused(const fs::path& out, const std::string& what) {
  return {ErrorKind::usage, out.string() + ": " + what};
}

}  // namespace

bool lies_in(const fs::path& inner, const fs::path& outer) {
  const fs::path a = fs::weakly_canonical(inner), b = fs::weakly_canonical(outer);
  return std::mismatch(b.begin(), b.end(), a.begin(), a.end()).first == b.end();
}

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
    return refused(given, "not a name; expected a file or folder to write");
  }
  if (lies_in(out, dataset)) return refused(out, "lies in the data set; name a place outside it");
  std::error_code error;
  const auto there = fs::symlink_status(out, error);
  if (fs::exists(there)) {
    const bool empty_folder = fs::is_directory(there) && fs::is_empty(out, error) && !error;
    if (!is_folder && !replace) {
      return refused(out, "already exists; remove it or name another file");
    }
    if (!is_folder && !fs::is_regular_file(there)) {
      return refused(out, "already exists and is not a file; name another file");
    }
    if (is_folder && !empty_folder) {
      return refused(out, "is not empty; empty it or name another folder");
    }
  }
  const fs::path parent = out.parent_path();
  fs::create_directories(parent, error);
  if (error) return write_error(parent, error.value());
  OutputPlace place(out, temporary_beside(out));
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

Status write_whole(const fs::path& path, std::string_view bytes) {
  StreamedFile file(path);
  file.append(bytes);
  return file.close();
}

Status copy_whole(const fs::path& from, const fs::path& to) {
  const auto bytes = read_file(from);
  return bytes ? write_whole(to, *bytes) : Status(bytes.error());
}

}  // namespace ensonify
