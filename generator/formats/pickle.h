// Python's pickle format, as far as a dictionary of NumPy arrays needs it.
// (https://docs.python.org/3/library/pickletools.html)
//
//   PickledArray  encode_pickle   {name: array, ...}
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "formats/npy.h"

namespace ensonify {

struct PickledArray {
  std::string_view name;   // ASCII, at most 255 characters
  std::string_view dtype;  // as NumPy names it, without byte order: f4 or f8
  NpyShape shape;          // one to three sides
  std::string_view data;   // little-endian, in C order
};

// Protocol 3, which every Python 3 reads: before it, there were no bytes, and the data would have
// to be text. NumPy 1 and 2 read the arrays, which can be written to. Error (usage), without the
// file's name: an array of 4 GiB or more.
Result<std::string> encode_pickle(const std::vector<PickledArray>& arrays);

}  // namespace ensonify
