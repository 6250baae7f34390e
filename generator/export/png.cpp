#include "export/png.h"

#include <png.h>

#include <stdexcept>

namespace ensonify {
namespace {

// libpng's own way out is a long jump, which must not pass over objects of C++; with these it
// throws instead.
[[noreturn]] void fail(png_structp, png_const_charp message) { throw std::runtime_error(message); }
void ignore(png_structp, png_const_charp) {}

void put_bytes(png_structp png, png_bytep bytes, png_size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))
      ->append(static_cast<const char*>(static_cast<const void*>(bytes)), count);
}

struct Writer {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, ignore);
  png_infop info = png_create_info_struct(png);
  Writer() = default;
  ~Writer() { png_destroy_write_struct(&png, &info); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
};

}  // namespace

Result<std::string> encode_palette(std::span<const std::uint8_t> indices, std::uint32_t rows,
                                   std::uint32_t columns, const Palette& palette) {
  ENSONIFY_ASSERT(rows > 0 && columns > 0 && indices.size() == std::size_t{rows} * columns);
  std::string bytes;
  std::array<png_color, 256> colors;
  for (std::size_t i = 0; i < colors.size(); ++i) {
    colors[i] = {palette[i][0], palette[i][1], palette[i][2]};
  }
  try {
    Writer writer;
    png_set_write_fn(writer.png, &bytes, put_bytes, nullptr);
    png_set_IHDR(writer.png, writer.info, columns, rows, 8, PNG_COLOR_TYPE_PALETTE,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_PLTE(writer.png, writer.info, colors.data(), static_cast<int>(colors.size()));
    png_write_info(writer.png, writer.info);
    for (std::uint32_t row = 0; row < rows; ++row) {
      png_write_row(writer.png, indices.data() + std::size_t{row} * columns);
    }
    png_write_end(writer.png, nullptr);
  } catch (const std::runtime_error& error) {
    return Error{ErrorKind::bug, std::string("encoding a PNG picture: ") + error.what()};
  }
  return bytes;
}

}  // namespace ensonify
