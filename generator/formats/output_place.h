// Output that is made from a data set and written elsewhere.
//
//   OutputPlace             OUT under a temporary name next to it until it is complete
//   write_whole  copy_whole  a file at once; piece by piece: StreamedFile of files.h
//   lies_in                 ... whether one place is in another
//
// Errors: (usage) OUT already holds something; (io) it cannot be written.
#pragma once

#include <filesystem>
#include <string_view>

#include "core/error.h"

namespace ensonify {

// Resolves links as far as the path exists; a place lies in itself.
bool lies_in(const std::filesystem::path& inner, const std::filesystem::path& outer);

class OutputPlace {
 public:
  // OUT must not exist, or must be an empty folder if a folder is written; with `replace` it may be
  // a file. It must not lie in the data set, which would no longer verify. Creates parent folders.
  static Result<OutputPlace> open(const std::filesystem::path& out, bool is_folder,
                                  const std::filesystem::path& dataset, bool replace = false);
  ~OutputPlace();  // removes what was not committed
  OutputPlace(OutputPlace&& other) noexcept;
  OutputPlace& operator=(OutputPlace&&) = delete;

  // Where to write: an existing folder, or the name of a new file.
  const std::filesystem::path& temporary() const { return temporary_; }
  Status commit();

 private:
  OutputPlace(std::filesystem::path out, std::filesystem::path temporary);

  std::filesystem::path out_, temporary_;
};

// Writes a file at once and creates its parent folders.
Status write_whole(const std::filesystem::path& path, std::string_view bytes);
Status copy_whole(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace ensonify
