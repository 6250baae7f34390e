#include "formats/pickle.h"

#include <cstdint>
#include <limits>

#include "formats/bytes.h"

namespace ensonify {
namespace {

// Opcodes, by their names in pickletools.
constexpr char kProto = '\x80', kStop = '.', kEmptyDict = '}', kMark = '(', kSetItems = 'u';
constexpr char kGlobal = 'c', kReduce = 'R', kBuild = 'b', kNone = 'N';
constexpr char kTuple = 't', kTuple1 = '\x85', kTuple2 = '\x86', kTuple3 = '\x87';
constexpr char kNewFalse = '\x89', kNewTrue = '\x88';
constexpr char kBinInt = 'J', kBinUnicode = 'X', kShortBinBytes = 'C', kBinBytes = 'B';

void put_text(std::string& out, std::string_view text) {
  out += kBinUnicode;
  put_value(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}

void put_int(std::string& out, std::int32_t value) {
  out += kBinInt;
  put_value(out, value);
}

void put_global(std::string& out, std::string_view module, std::string_view name) {
  out += kGlobal;
  out.append(module).append("\n").append(name).append("\n");
}

void put_flag(std::string& out, bool flag) { out += flag ? kNewTrue : kNewFalse; }

// What numpy.dtype.__reduce__ returns for a little-endian number.
void put_dtype(std::string& out, std::string_view dtype) {
  put_global(out, "numpy", "dtype");
  put_text(out, dtype);
  put_flag(out, false);
  put_flag(out, true);
  out += kTuple3;
  out += kReduce;
  out += kMark;
  put_int(out, 3);
  put_text(out, "<");
  out.append(3, kNone);
  put_int(out, -1);
  put_int(out, -1);
  put_int(out, 0);
  out += kTuple;
  out += kBuild;
}

// What numpy.ndarray.__reduce__ returns: an empty array, then its state.
void put_array(std::string& out, const PickledArray& array) {
  // NumPy 2 keeps this name for files of NumPy 1.
  put_global(out, "numpy.core.multiarray", "_reconstruct");
  put_global(out, "numpy", "ndarray");
  put_int(out, 0);
  out += kTuple1;
  out += kShortBinBytes;
  out +=
      "\x01"
      "b";
  out += kTuple3;
  out += kReduce;
  out += kMark;
  put_int(out, 1);
  for (const std::uint64_t side : array.shape) put_int(out, static_cast<std::int32_t>(side));
  const std::size_t sides = array.shape.size();
  out += sides == 1 ? kTuple1 : sides == 2 ? kTuple2 : kTuple3;
  put_dtype(out, array.dtype);
  put_flag(out, false);
  out += kBinBytes;
  put_value(out, static_cast<std::uint32_t>(array.data.size()));
  out += array.data;
  out += kTuple;
  out += kBuild;
}

}  // namespace

Result<std::string> encode_pickle(const std::vector<PickledArray>& arrays) {
  std::string out = {kProto, '\x03', kEmptyDict, kMark};
  for (const PickledArray& array : arrays) {
    if (array.data.size() > std::numeric_limits<std::uint32_t>::max()) {
      return Error{ErrorKind::usage, "an image of 4 GiB or more does not fit into a pickle"};
    }
    for (const std::uint64_t side : array.shape) ENSONIFY_ASSERT(side <= INT32_MAX);
    ENSONIFY_ASSERT(!array.shape.empty() && array.shape.size() <= 3);
    put_text(out, array.name);
    put_array(out, array);
  }
  out += kSetItems;
  out += kStop;
  return out;
}

}  // namespace ensonify
