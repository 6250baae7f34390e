// NPY arrays of a data set, read again.
//
//   read_npy       a whole array, its shape checked
//   read_npy_row   one row of it
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/error.h"
#include "dataset/npy.h"

namespace ensonify {

struct NpyArray {
  NpyShape shape;
  std::string file;  // header and data
  std::size_t offset = 0;

  std::string_view data() const { return std::string_view(file).substr(offset); }
};

// A shape of one element that is 0 stands for any length. Error (io): another type or shape, or cut
// short.
Result<NpyArray> read_npy(const std::filesystem::path& path, std::string_view descr,
                          const NpyShape& shape);

Result<std::string> read_npy_row(const std::filesystem::path& path, std::string_view descr,
                                 const NpyShape& shape, std::uint64_t row);

}  // namespace ensonify
