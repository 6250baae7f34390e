// The only source that includes libpng.
#include <png.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>

#include "world/grid_file.h"

namespace ensonify {
namespace {

// libpng leaves by longjmp, past every destructor between: what it works on lives here, in the
// frame of whoever calls, and is freed there.
struct PngReader {
  std::string_view rest;
  std::array<char, 200> trouble{};
  png_structp png = nullptr;
  png_infop info = nullptr;
  int rows = 0, columns = 0, bits = 0, color_type = 0;
  std::vector<unsigned char> pixels;

  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

void read_from_memory(png_structp png, png_bytep out, std::size_t count) {
  auto& reader = *static_cast<PngReader*>(png_get_io_ptr(png));
  if (count > reader.rest.size()) png_error(png, "it is cut off");
  std::memcpy(out, reader.rest.data(), count);
  reader.rest.remove_prefix(count);
}

void keep_trouble(png_structp png, png_const_charp message) {
  auto& reader = *static_cast<PngReader*>(png_get_error_ptr(png));
  std::strncpy(reader.trouble.data(), message, reader.trouble.size() - 1);
  png_longjmp(png, 1);
}

void pass_over(png_structp, png_const_charp) {}

bool read_header(PngReader& reader) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_set_read_fn(reader.png, &reader, read_from_memory);
  png_set_user_limits(reader.png, kMaxGridCells, kMaxGridCells);
  png_read_info(reader.png, reader.info);
  reader.rows = static_cast<int>(png_get_image_height(reader.png, reader.info));
  reader.columns = static_cast<int>(png_get_image_width(reader.png, reader.info));
  reader.bits = png_get_bit_depth(reader.png, reader.info);
  reader.color_type = png_get_color_type(reader.png, reader.info);
  return true;
}

// Into `pixels`, which holds the whole picture.
bool read_pixels(PngReader& reader) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  const std::size_t row_bytes = reader.pixels.size() / reader.rows;
  const int passes = png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  for (int pass = 0; pass < passes; ++pass) {
    for (int row = 0; row < reader.rows; ++row) {
      png_read_row(reader.png, reader.pixels.data() + row * row_bytes, nullptr);
    }
  }
  png_read_end(reader.png, nullptr);
  return true;
}

Error broken(const PngReader& reader) {
  return {ErrorKind::usage,
          fmt::format("is no PNG file that can be read: {}", reader.trouble.data())};
}

}  // namespace

Result<GridFile> parse_png_grid(std::string_view bytes) {
  PngReader reader;
  reader.rest = bytes;
  reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, keep_trouble, pass_over);
  if (reader.png == nullptr) return Error{ErrorKind::device, "no memory for reading a PNG file"};
  reader.info = png_create_info_struct(reader.png);
  if (reader.info == nullptr) return Error{ErrorKind::device, "no memory for reading a PNG file"};
  if (!read_header(reader)) return broken(reader);
  if (reader.color_type != PNG_COLOR_TYPE_GRAY || reader.bits < 8) {
    return Error{ErrorKind::usage,
                 fmt::format("is a PNG file of {} bits and color type {}, accepted are grey ones "
                             "(color type 0) of 8 or 16 bits",
                             reader.bits, reader.color_type)};
  }
  if (Status size = check_grid_size(reader.rows, reader.columns); !size) return size.error();
  const std::size_t count = std::size_t(reader.rows) * reader.columns;
  reader.pixels.resize(count * reader.bits / 8);
  if (!read_pixels(reader)) return broken(reader);

  GridFile grid{reader.rows, reader.columns, std::vector<double>(count),
                reader.bits == 8 ? 255.0 : 65535.0, 0};
  const auto& p = reader.pixels;
  for (std::size_t i = 0; i < count; ++i) {
    grid.values[i] = reader.bits == 8 ? p[i] : p[2 * i] * 256 + p[2 * i + 1];
  }
  return grid;
}

}  // namespace ensonify
