#include "dataset/png.h"

#include <png.h>
#include <zlib.h>

#include <bit>
#include <csetjmp>
#include <new>

namespace ensonify {
namespace {

struct GreyView {
  const png_byte* pixels;
  std::size_t row_bytes;
  int rows, columns, bit_depth;
  PngContent content;
};

// libpng is C: no exception may cross it, so a failed allocation leaves by its own way.
void append_bytes(png_structp png, png_bytep data, std::size_t size) {
  auto* out = static_cast<std::string*>(png_get_io_ptr(png));
  bool whole = true;
  try {
    out->append(static_cast<const char*>(static_cast<const void*>(data)), size);
  } catch (const std::bad_alloc&) {
    whole = false;
  }
  if (!whole) png_error(png, "out of memory");
}

void flush_nothing(png_structp) {}

void say_nothing(png_structp, png_const_charp) {}

// setjmp lives in a function of its own with nothing in it that has a destructor.
bool write_image(png_structp png, png_infop info, const GreyView& image) {
  if (setjmp(png_jmpbuf(png))) return false;
  const bool mask = image.content == PngContent::mask;
  png_set_compression_level(png, mask ? 6 : 1);
  // Speckle does not repeat but in dark runs: the search for matches triples the time and gains
  // nothing.
  if (!mask) png_set_compression_strategy(png, Z_RLE);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, mask ? PNG_FILTER_UP : PNG_FILTER_NONE);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.columns),
               static_cast<png_uint_32>(image.rows), image.bit_depth, PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  if (image.bit_depth == 16 && std::endian::native == std::endian::little) png_set_swap(png);
  for (int row = 0; row < image.rows; ++row) {
    png_write_row(png, image.pixels + static_cast<std::size_t>(row) * image.row_bytes);
  }
  png_write_end(png, nullptr);
  return true;
}

Result<std::string> encode(const GreyView& image) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, say_nothing);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  bool written = false;
  if (info != nullptr) {
    png_set_write_fn(png, &bytes, append_bytes, flush_nothing);
    written = write_image(png, info, image);
  }
  png_destroy_write_struct(&png, &info);
  if (!written) return Error{ErrorKind::device, "out of memory while encoding a PNG picture"};
  return bytes;
}

template <class Pixel>
Result<std::string> encode_pixels(std::span<const Pixel> pixels, int rows, int columns,
                                  PngContent content) {
  ENSONIFY_ASSERT(rows > 0 && columns > 0);
  const auto width = static_cast<std::size_t>(columns);
  ENSONIFY_ASSERT(pixels.size() == static_cast<std::size_t>(rows) * width);
  return encode({static_cast<const png_byte*>(static_cast<const void*>(pixels.data())),
                 width * sizeof(Pixel), rows, columns, static_cast<int>(8 * sizeof(Pixel)),
                 content});
}

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (const char c : bytes.substr(0, 4)) value = value << 8 | static_cast<unsigned char>(c);
  return value;
}

}  // namespace

Result<std::string> encode_png(std::span<const std::uint8_t> pixels, int rows, int columns,
                               PngContent content) {
  return encode_pixels(pixels, rows, columns, content);
}

Result<std::string> encode_png(std::span<const std::uint16_t> pixels, int rows, int columns,
                               PngContent content) {
  return encode_pixels(pixels, rows, columns, content);
}

std::optional<PngHeader> parse_png_header(std::string_view bytes) {
  constexpr std::string_view kStart{"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16};
  if (bytes.size() < 33 || bytes.substr(0, kStart.size()) != kStart) return std::nullopt;
  return PngHeader{big_endian(bytes.substr(16)), big_endian(bytes.substr(20)),
                   static_cast<unsigned char>(bytes[24]), static_cast<unsigned char>(bytes[25])};
}

}  // namespace ensonify
