// Files that appear whole or not at all, and their folders.
//
//   write_file_atomically  write_hashed_file  StreamedFile   temporary name, then a rename
//   temporary_beside                      such a name
//   read_file  sha256_of_file             a whole file, and its hash, read in pieces
//   is_safe_relative_path                 whether it stays inside the folder, as written
//   listed_file_size                      ... and on disk, without links
//   files_below                           everything in a folder that is not a folder
//   remove_empty_folders                  folders without a file
//   read_error  write_error  damaged      Error values that name the file and what to do
//
// Files are not flushed to the disk: after a power loss a file may be short, which its size shows.
#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "formats/sha256.h"

namespace ensonify {

// A file as manifests list it.
struct FileEntry {
  std::string path;  // relative, '/' between its parts
  std::uint64_t bytes = 0;
  std::string sha256;
};

Error read_error(const std::filesystem::path& path, int error_number);
Error write_error(const std::filesystem::path& path, int error_number);
// Error for a damaged file of a data set.
Error damaged(const std::filesystem::path& path, const std::string& what);

// Folder in a data set for unfinished files.
inline constexpr char kTemporaryFolder[] = ".work/tmp";

// Writes DIR/relative and creates missing folders. The final name appears by rename, so that no
// reader sees a partial file and two processes that write the same bytes do not conflict; .work may
// vanish meanwhile. Error (io): the file and the system's reason; no file is left.
Result<FileEntry> write_file_atomically(const std::filesystem::path& dir,
                                        const std::string& relative, std::string_view bytes);

// The same if size and hash of the bytes are already known.
Status write_hashed_file(const std::filesystem::path& dir, const std::string& relative,
                         std::string_view bytes);

// The same for a file too long to hold in memory.
class StreamedFile {
 public:
  // DIR/relative, of a data set: the temporary file is in DIR/.work/tmp. With `hashed` false
  // commit() gives no hash.
  StreamedFile(const std::filesystem::path& dir, std::string relative, bool hashed = true);
  // Any other file: the temporary file is next to it, and there is no hash.
  explicit StreamedFile(std::filesystem::path path);
  ~StreamedFile();  // drops what was not committed
  StreamedFile(const StreamedFile&) = delete;
  StreamedFile& operator=(const StreamedFile&) = delete;

  // Keeps a failure, which commit() returns.
  void append(std::string_view bytes);
  // Appends the content of another uncommitted file; keeps its failure too.
  void append_all_of(StreamedFile& other);
  std::uint64_t bytes() const { return bytes_; }
  // Gives the file its name. Call one of the two, once.
  Result<FileEntry> commit();
  Status close();

 private:
  bool open_temporary();
  bool write_all(std::string_view bytes);
  bool rename_to_final();
  bool recover_vanished(int descriptor);

  std::filesystem::path path_;
  std::optional<std::filesystem::path> temporary_folder_;
  std::string name_;
  bool hashed_ = false;
  std::filesystem::path temporary_;
  int descriptor_ = -1;
  int error_number_ = 0;
  std::string buffer_;
  std::uint64_t bytes_ = 0;
  Sha256 hash_;
};

// A unique hidden name next to the path.
std::filesystem::path temporary_beside(const std::filesystem::path& path);

// Error (io): cannot be read, is no regular file (a pipe would never end), or is larger than that.
Result<std::string> read_file(const std::filesystem::path& path,
                              std::uint64_t most_bytes = UINT64_MAX);

// Error (io): the file cannot be read.
Result<std::string> sha256_of_file(const std::filesystem::path& path);

// Size limit of dataset.json and other top-level manifests: room for 1,000,000 sequences, the limit
// of a scenario.
inline constexpr std::uint64_t kMaxManifestBytes = std::uint64_t{512} << 20;

// Not empty, not absolute, and no part of it empty, "." or "..".
bool is_safe_relative_path(std::string_view path);

// Size of the regular file DIR/relative; none if it is missing, not a regular file, or reached
// through a link, which could lead out of DIR.
std::optional<std::uint64_t> listed_file_size(const std::filesystem::path& dir,
                                              const std::string& relative);

// Sorted relative paths of everything except folders; links are listed, not followed.
Result<std::vector<std::string>> files_below(const std::filesystem::path& dir);

// Removes `folder` and the folders in it if they hold no files. Does not follow links.
void remove_empty_folders(const std::filesystem::path& folder);

// Runs a body that returns a Result or Status and turns exceptions of libraries into Errors.
template <class Body>
auto without_exceptions(const std::string& doing, Body body) -> decltype(body()) {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return Error{ErrorKind::device, doing + ": out of memory; use fewer threads"};
  } catch (const std::filesystem::filesystem_error& error) {
    return Error{ErrorKind::io, doing + ": " + error.what()};
  } catch (const std::exception& error) {
    return Error{ErrorKind::bug, doing + ": " + error.what()};
  }
}

}  // namespace ensonify
