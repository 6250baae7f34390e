// The page's place on disk. Private to report/.
//
//   PageOutput   written under another name beside it, until it is whole
//
// Errors: (usage) another file stands there, or the place would damage the data set; (io) it cannot
// be written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/error.h"

namespace ensonify {

class PageOutput {
 public:
  // Looks at the place, and writes nothing yet. `output` empty: DIR_report.html beside the data
  // set. A page of ours is replaced, another file only with `overwrite`.
  static Result<PageOutput> open(const std::filesystem::path& output,
                                 const std::filesystem::path& dataset, bool overwrite);
  ~PageOutput();  // removes what was not committed
  PageOutput(PageOutput&& other) noexcept;
  PageOutput& operator=(PageOutput&&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t bytes() const { return bytes_; }

  // A failure is kept and comes out of commit().
  void append(std::string_view bytes);
  Status commit();

 private:
  explicit PageOutput(std::filesystem::path path) : path_(std::move(path)) {}

  std::filesystem::path path_, temporary_;
  int descriptor_ = -1;
  int error_number_ = 0;
  std::uint64_t bytes_ = 0;
};

}  // namespace ensonify
