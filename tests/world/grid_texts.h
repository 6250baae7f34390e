// Grids as files hold them, for the tests of this folder.
#pragma once

#include <png.h>

#include <cstdint>
#include <string>
#include <vector>

namespace ensonify::test {

// Version 1.0, with the header text given and the bytes of the values behind it.
template <class T>
std::string npy(const std::string& header, const std::vector<T>& values) {
  std::string bytes = "\x93NUMPY";
  bytes += '\1';
  bytes += '\0';
  bytes += static_cast<char>(header.size() & 255);
  bytes += static_cast<char>(header.size() >> 8);
  bytes += header;
  return bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

inline std::string npy_header(const std::string& type, int rows, int columns,
                              bool by_columns = false) {
  return "{'descr': '" + type + "', 'fortran_order': " + (by_columns ? "True" : "False") +
         ", 'shape': (" + std::to_string(rows) + ", " + std::to_string(columns) + "), }\n";
}

template <class T>
std::string npy(const std::string& type, int rows, int columns, const std::vector<T>& values) {
  return npy(npy_header(type, rows, columns), values);
}

// Pixels as `format` of libpng's simple interface: PNG_FORMAT_LINEAR_Y for 16 bits, ...
inline std::string png(const void* pixels, int rows, int columns, std::uint32_t format) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(columns);
  image.height = static_cast<png_uint_32>(rows);
  image.format = format;
  std::string bytes(1000 + 16 * std::size_t(rows) * columns, '\0');
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels, 0, nullptr) == 0) return "";
  bytes.resize(size);
  return bytes;
}

}  // namespace ensonify::test
