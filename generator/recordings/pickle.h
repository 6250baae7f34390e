// NumPy arrays from a Python pickle, without Python: a pickle can name any function, and nothing
// here calls one.
//
//   UnpickledArray  values_of    an array, and its numbers
//   Unpickled  unpickle_arrays   the arrays of a dictionary
//
// While it is read, private to recordings/:
//
//   pickle::PickleValue  Kind  Global   a value, and the functions that a pickle may name
//   global_of  printable   a function by its name; a name for messages
//   is_text  is_dtype      texts, and codes of types, that are read
//   latin1_of              the bytes of a text
//   is_consistent          whether an array has the bytes that it needs
//
// Format: https://docs.python.org/3/library/pickletools.html, protocols 2 to 5, as pickle.dump
// writes dictionaries of texts, numbers, tuples, bytes and arrays. Arrays come from
// numpy.core.multiarray._reconstruct and numpy.core.numeric._frombuffer (or numpy._core), their
// types from numpy.dtype, and bytes of protocol 2 from _codecs.encode.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace ensonify {

struct UnpickledArray {
  std::string dtype;  // kind and size in bytes: "f4", "u1"
  bool big_endian = false, fortran_order = false;
  std::vector<std::uint64_t> shape;
  std::string_view data;  // as many bytes as type and shape need
};

// In C order.
std::vector<double> values_of(const UnpickledArray& array);

struct Unpickled {
  std::deque<std::string> decoded;  // bytes that protocol 2 keeps as text
  // By key. Other values, and keys of more than 64 bytes, are left out.
  std::map<std::string, UnpickledArray> arrays;
};

// The arrays refer to `bytes`, which must outlive them, and to `decoded`. Allocates a fixed amount
// and at most the size of `bytes`. Error (usage), "byte OFFSET: WHAT": an opcode or a global that
// is not one of those above, a damaged pickle, or no dictionary.
Result<Unpickled> unpickle_arrays(std::string_view bytes);

namespace pickle {

inline constexpr std::size_t kLongestGlobal = 64, kMostSides = 8;

enum class Kind { none, number, real, text, bytes, tuple, dict, global, dtype, array };
enum class Global { ndarray, dtype, reconstruct, frombuffer, encode };

struct PickleValue {
  Kind kind = Kind::none;
  std::int64_t number = 0;  // also of a truth value
  Global global = Global::ndarray;
  std::string_view text;             // also bytes
  std::vector<std::uint32_t> items;  // of a tuple; keys and values of a dict, in turn
  UnpickledArray array;              // of a dtype: its dtype and order
};

std::optional<Global> global_of(std::string_view module, std::string_view name);
std::string printable(std::string_view text);
inline bool is_text(const PickleValue& value) {
  return value.kind == Kind::text || value.kind == Kind::bytes;
}
bool is_dtype(std::string_view code);

// None if a character is above 255 or the text is not UTF-8.
std::optional<std::string> latin1_of(std::string_view utf8);

// In Fortran order arrays have two sides at most.
bool is_consistent(const UnpickledArray& array);

}  // namespace pickle
}  // namespace ensonify
