// What is made from a data set and written elsewhere.
//
//   OutputPlace             OUT under a temporary name beside it, until it is whole
//   write_whole  copy_whole  a file at once; piece by piece: StreamedFile of files.h
//   lies_in                 ... whether one place is in another
//
// Errors: (usage) OUT holds something already; (io) it cannot be written.
#pragma once

#include <filesystem>
#include <string_view>

#include "core/error.h"

namespace ensonify {

// Links resolved as far as there is something; a place lies in itself.
bool lies_in(const std::filesystem::path& inner, const std::filesystem::path& outer);

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

// Of a file that is written at once; makes the folders above it.
Status write_whole(const std::filesystem::path& path, std::string_view bytes);
Status copy_whole(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace ensonify
