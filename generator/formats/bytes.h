// Values in bytes, little-endian and without padding, as all formats here except PNG pack them.
//
//   put_value  put_value_at   appends to the bytes, or writes at a pointer and advances it, or at
//                             an offset
//   value_at  values_in    read them
//   base64  base64_bytes   as text (RFC 4648), and its length
//   to_halves  from_halves  round_to_halves   floats as the pixels of EXR images hold them
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ensonify {

static_assert(std::endian::native == std::endian::little,
              "values are written as they lie in memory");

template <class T>
void put_value(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof raw);
}

template <class T>
void put_value(char*& at, T value) {
  std::memcpy(at, &value, sizeof value);
  at += sizeof value;
}

// Needs the value to lie within the bytes.
template <class T>
void put_value_at(std::string& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

// Likewise.
template <class T>
T value_at(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

// Reads as many values as the bytes contain.
template <class T>
std::vector<T> values_in(std::string_view bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) {
    std::memcpy(static_cast<void*>(values.data()), bytes.data(), values.size() * sizeof(T));
  }
  return values;
}

std::string base64(std::string_view bytes);
constexpr std::uint64_t base64_bytes(std::uint64_t bytes) { return (bytes + 2) / 3 * 4; }

// The bits of the nearest halves, half to even. Values beyond the range become +-65504; every NaN
// becomes 0x7fff. Needs spans of one size.
void to_halves(std::span<const float> values, std::span<std::uint16_t> halves);

// Exact. Needs spans of one size.
void from_halves(std::span<const std::uint16_t> halves, std::span<float> values);

// Rounds each value as storing it in a file does.
void round_to_halves(std::span<float> values);

}  // namespace ensonify
