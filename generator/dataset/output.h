// What is made from a data set and written elsewhere.
//
//   OutputPlace             OUT under a temporary name beside it, until it is whole
//   OutputFile              one file, written piece by piece
//   write_whole  copy_whole  a file at once
//
// Errors: (usage) OUT holds something already; (io) it cannot be written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/error.h"

namespace ensonify {

class OutputPlace {
 public:
  // OUT must not be there, or, where a folder is to be written, be an empty one; with `replace` it
  // may be a file. It must not lie in the data set, which would no longer be whole. Folders above
  // it are made.
  static Result<OutputPlace> open(const std::filesystem::path& out, bool is_folder,
                                  const std::filesystem::path& dataset, bool replace = false);
  ~OutputPlace();  // removes what was not committed
  OutputPlace(OutputPlace&& other) noexcept;
  OutputPlace& operator=(OutputPlace&&) = delete;

  // Where to write: a folder that is there, or the name of a file that is not.
  const std::filesystem::path& temporary() const { return temporary_; }
  Status commit();

 private:
  OutputPlace(std::filesystem::path out, std::filesystem::path temporary);

  std::filesystem::path out_, temporary_;
};

class OutputFile {
 public:
  // Makes the folders above it.
  explicit OutputFile(std::filesystem::path path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  // A failure is kept and comes out of close().
  void append(std::string_view bytes);
  std::uint64_t bytes() const { return bytes_; }
  Status close();

 private:
  void flush();

  std::filesystem::path path_;
  int descriptor_ = -1;
  int error_number_ = 0;
  std::uint64_t bytes_ = 0;
  std::string buffer_;
};

Status write_whole(const std::filesystem::path& path, std::string_view bytes);
Status copy_whole(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace ensonify
