// NumPy arrays from a Python pickle, without Python: a pickle can name any function, and nothing
// here calls one.
//
//   Unpickled  unpickle_arrays   the arrays of a dictionary
//
// Format: https://docs.python.org/3/library/pickletools.html, protocols 2 to 5, as pickle.dump
// writes dictionaries of texts, numbers, tuples, bytes and arrays. Arrays come from
// numpy.core.multiarray._reconstruct and numpy.core.numeric._frombuffer (or numpy._core), their
// types from numpy.dtype, and bytes of protocol 2 from _codecs.encode.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "recordings/pickle_value.h"

namespace ensonify {

struct Unpickled {
  std::deque<std::string> decoded;  // bytes that protocol 2 keeps as text
  // By key. Other values, and keys of more than 64 bytes, are left out.
  std::map<std::string, UnpickledArray> arrays;
};

// The arrays refer to `bytes`, which must outlive them, and to `decoded`. Allocates a fixed amount
// and at most the size of `bytes`. Error (usage), "byte OFFSET: WHAT": an opcode or a global that
// is not one of those above, a damaged pickle, or no dictionary.
Result<Unpickled> unpickle_arrays(std::string_view bytes);

}  // namespace ensonify
