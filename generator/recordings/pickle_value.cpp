#include "recordings/pickle.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace ensonify {
namespace pickle {

std::optional<Global> global_of(std::string_view module, std::string_view name) {
  constexpr struct {
    std::string_view module, name;
    Global global;
  } kGlobals[] = {
      {"numpy", "ndarray", Global::ndarray},
      {"numpy", "dtype", Global::dtype},
      {"numpy.core.multiarray", "_reconstruct", Global::reconstruct},
      {"numpy._core.multiarray", "_reconstruct", Global::reconstruct},
      {"numpy.core.numeric", "_frombuffer", Global::frombuffer},
      {"numpy._core.numeric", "_frombuffer", Global::frombuffer},
      {"_codecs", "encode", Global::encode},
  };
  for (const auto& known : kGlobals) {
    if (known.module == module && known.name == name) return known.global;
  }
  return std::nullopt;
}

std::string printable(std::string_view text) {
  std::string shown(text.substr(0, kLongestGlobal));
  for (char& c : shown) c = c >= ' ' && c <= '~' ? c : '?';
  return shown;
}

std::optional<std::string> latin1_of(std::string_view utf8) {
  std::string bytes;
  bytes.reserve(utf8.size());
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto byte = static_cast<unsigned char>(utf8[i]);
    if (byte < 0x80) {
      bytes += utf8[i];
      continue;
    }
    if ((byte != 0xc2 && byte != 0xc3) || i + 1 == utf8.size()) return std::nullopt;
    const auto next = static_cast<unsigned char>(utf8[++i]);
    if ((next & 0xc0) != 0x80) return std::nullopt;
    bytes += static_cast<char>((byte & 3) << 6 | (next & 0x3f));
  }
  return bytes;
}

bool is_dtype(std::string_view code) {
  constexpr std::string_view kCodes[] = {"f4", "f8", "i1", "i2", "i4", "i8",
                                         "u1", "u2", "u4", "u8", "b1"};
  return std::find(std::begin(kCodes), std::end(kCodes), code) != std::end(kCodes);
}

bool is_consistent(const UnpickledArray& array) {
  if (array.fortran_order && array.shape.size() > 2) return false;
  std::uint64_t size = static_cast<std::uint64_t>(array.dtype[1] - '0');
  for (const std::uint64_t side : array.shape) {
    if (side > 0 && size > array.data.size() / side) return false;
    size *= side;
  }
  return size == array.data.size();
}

}  // namespace pickle

namespace {

template <class T>
void read_values(const UnpickledArray& array, std::vector<double>& values) {
  const std::size_t columns = array.shape.size() == 2 ? array.shape[1] : 1;
  const std::size_t rows = columns == 0 ? 0 : values.size() / columns;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t from = array.fortran_order ? i % columns * rows + i / columns : i;
    char raw[sizeof(T)];
    std::memcpy(raw, array.data.data() + from * sizeof(T), sizeof(T));
    if (array.big_endian) std::reverse(raw, raw + sizeof(T));
    values[i] = static_cast<double>(std::bit_cast<T>(raw));
  }
}

}  // namespace

std::vector<double> values_of(const UnpickledArray& array) {
  const std::size_t size = static_cast<std::size_t>(array.dtype[1] - '0');
  std::vector<double> values(array.data.size() / size);
  const std::string& type = array.dtype;
  if (type == "f4") read_values<float>(array, values);
  if (type == "f8") read_values<double>(array, values);
  if (type == "i1") read_values<std::int8_t>(array, values);
  if (type == "i2") read_values<std::int16_t>(array, values);
  if (type == "i4") read_values<std::int32_t>(array, values);
  if (type == "i8") read_values<std::int64_t>(array, values);
  if (type == "u1" || type == "b1") read_values<std::uint8_t>(array, values);
  if (type == "u2") read_values<std::uint16_t>(array, values);
  if (type == "u4") read_values<std::uint32_t>(array, values);
  if (type == "u8") read_values<std::uint64_t>(array, values);
  return values;
}

}  // namespace ensonify
