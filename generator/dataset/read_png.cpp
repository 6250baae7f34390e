#include "dataset/read_png.h"

#include <png.h>

#include <cstring>
#include <stdexcept>

#include "dataset/files.h"
#include "dataset/read_dataset.h"

namespace ensonify {
namespace {

// libpng's own way out is a long jump, which must not pass over objects of C++; with these it
// throws instead.
[[noreturn]] void fail(png_structp, png_const_charp message) { throw std::runtime_error(message); }
void ignore(png_structp, png_const_charp) {}

void take_bytes(png_structp png, png_bytep out, png_size_t count) {
  auto& rest = *static_cast<std::string_view*>(png_get_io_ptr(png));
  if (count > rest.size()) throw std::runtime_error("it ends too early");
  std::memcpy(out, rest.data(), count);
  rest.remove_prefix(count);
}

struct Reader {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, ignore);
  png_infop info = png_create_info_struct(png);
  Reader() = default;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
};

template <class Pixel>
Result<std::vector<Pixel>> read_grey(const std::filesystem::path& path, std::uint64_t rows,
                                     std::uint64_t columns) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  std::string_view rest = *bytes;
  try {
    Reader reader;
    png_set_read_fn(reader.png, &rest, take_bytes);
    png_read_info(reader.png, reader.info);
    if (png_get_image_height(reader.png, reader.info) != rows ||
        png_get_image_width(reader.png, reader.info) != columns ||
        png_get_bit_depth(reader.png, reader.info) != 8 * sizeof(Pixel) ||
        png_get_color_type(reader.png, reader.info) != PNG_COLOR_TYPE_GRAY ||
        png_get_interlace_type(reader.png, reader.info) != PNG_INTERLACE_NONE) {
      return damaged(path, "is not of the size and depth that sequence.json tells");
    }
    // Deflate packs at most 1,032 bytes into one.
    if (rows * columns * sizeof(Pixel) / 1032 > bytes->size()) {
      return damaged(path, "claims more pixels than it has");
    }
    if constexpr (sizeof(Pixel) == 2) png_set_swap(reader.png);
    std::vector<Pixel> pixels(rows * columns);
    for (std::uint64_t row = 0; row < rows; ++row) {
      png_read_row(reader.png,
                   static_cast<png_bytep>(static_cast<void*>(pixels.data() + row * columns)),
                   nullptr);
    }
    png_read_end(reader.png, nullptr);
    return pixels;
  } catch (const std::runtime_error& error) {
    return damaged(path, std::string("not a readable PNG: ") + error.what());
  }
}

}  // namespace

Result<std::vector<std::uint8_t>> read_grey8(const std::filesystem::path& path, std::uint64_t rows,
                                             std::uint64_t columns) {
  return read_grey<std::uint8_t>(path, rows, columns);
}

Result<std::vector<std::uint16_t>> read_grey16(const std::filesystem::path& path,
                                               std::uint64_t rows, std::uint64_t columns) {
  return read_grey<std::uint16_t>(path, rows, columns);
}

}  // namespace ensonify
