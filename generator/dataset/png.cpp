#include "dataset/png.h"

#include <libdeflate.h>

#include <algorithm>
#include <vector>

#include "dataset/deflate.h"
#include "dataset/files.h"

namespace ensonify {
namespace {

constexpr std::string_view kStart{"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16};
constexpr std::size_t kMaxChunkBytes = 0x7fffffff;

void put_big_endian(std::string& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
}

// Fills in the length of the chunk whose length field is at `start`, and adds its checksum.
void end_chunk(std::string& bytes, std::size_t start) {
  const std::size_t size = bytes.size() - start - 8;
  ENSONIFY_ASSERT(size <= kMaxChunkBytes);
  std::string length;
  put_big_endian(length, static_cast<std::uint32_t>(size));
  bytes.replace(start, 4, length);
  // Over type and content.
  put_big_endian(bytes, libdeflate_crc32(0, bytes.data() + start + 4, size + 4));
}

std::size_t begin_chunk(std::string& bytes, std::string_view type) {
  const std::size_t start = bytes.size();
  bytes.append(4, '\0').append(type);
  return start;
}

void put_row(std::span<const std::uint8_t> row, std::uint8_t* out) {
  std::copy(row.begin(), row.end(), out);
}

void put_row(std::span<const std::uint16_t> row, std::uint8_t* out) {
  for (std::size_t i = 0; i < row.size(); ++i) {
    out[2 * i] = static_cast<std::uint8_t>(row[i] >> 8);
    out[2 * i + 1] = static_cast<std::uint8_t>(row[i]);
  }
}

// Rows without a filter: speckle gains nothing by one, and in masks a change of value would be
// written twice.
template <class Pixel>
std::vector<std::uint8_t> rows_of(std::span<const Pixel> pixels, std::size_t columns) {
  const std::size_t rows = pixels.size() / columns;
  const std::size_t row_bytes = 1 + columns * sizeof(Pixel);
  std::vector<std::uint8_t> bytes(rows * row_bytes);
  for (std::size_t row = 0; row < rows; ++row) {
    put_row(pixels.subspan(row * columns, columns), bytes.data() + row * row_bytes + 1);
  }
  return bytes;
}

template <class Pixel>
Result<std::string> encode_pixels(std::span<const Pixel> pixels, int rows, int columns,
                                  Content content) {
  ENSONIFY_ASSERT(rows > 0 && columns > 0);
  ENSONIFY_ASSERT(pixels.size() ==
                  static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  return without_exceptions("encoding a PNG picture", [&]() -> Result<std::string> {
    std::string bytes(kStart.substr(0, 8));
    std::size_t chunk = begin_chunk(bytes, "IHDR");
    put_big_endian(bytes, static_cast<std::uint32_t>(columns));
    put_big_endian(bytes, static_cast<std::uint32_t>(rows));
    bytes += static_cast<char>(8 * sizeof(Pixel));
    bytes.append(4, '\0');  // grey; the only compression and filters there are; not interlaced
    end_chunk(bytes, chunk);
    chunk = begin_chunk(bytes, "IDAT");
    append_zlib(rows_of(pixels, static_cast<std::size_t>(columns)), content, bytes);
    end_chunk(bytes, chunk);
    chunk = begin_chunk(bytes, "IEND");
    end_chunk(bytes, chunk);
    return bytes;
  });
}

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (const char c : bytes.substr(0, 4)) value = value << 8 | static_cast<unsigned char>(c);
  return value;
}

}  // namespace

Result<std::string> encode_png(std::span<const std::uint8_t> pixels, int rows, int columns,
                               Content content) {
  return encode_pixels(pixels, rows, columns, content);
}

Result<std::string> encode_png(std::span<const std::uint16_t> pixels, int rows, int columns,
                               Content content) {
  return encode_pixels(pixels, rows, columns, content);
}

std::optional<PngHeader> parse_png_header(std::string_view bytes) {
  if (bytes.size() < 33 || bytes.substr(0, kStart.size()) != kStart) return std::nullopt;
  return PngHeader{big_endian(bytes.substr(16)), big_endian(bytes.substr(20)),
                   static_cast<unsigned char>(bytes[24]), static_cast<unsigned char>(bytes[25])};
}

}  // namespace ensonify
