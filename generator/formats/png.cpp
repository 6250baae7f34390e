#include "formats/png.h"

#include <png.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "formats/files.h"

namespace ensonify {
namespace {

constexpr std::string_view kStart{"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16};
constexpr std::size_t kMaxChunkBytes = 0x7fffffff;
constexpr std::uint64_t kMostInflation = 1032;  // bytes that deflate packs into one, at most
constexpr const char* kTooManyPixels = "its header gives more pixels than it holds";

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
  // The checksum covers type and content.
  put_big_endian(bytes, crc32_of(std::string_view(bytes).substr(start + 4)));
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

void put_row(std::span<const RgbPixel> row, std::uint8_t* out) {
  for (const RgbPixel& pixel : row) out = std::copy(pixel.begin(), pixel.end(), out);
}

template <class Pixel>
struct PixelKind {
  static constexpr int kBits = 8 * sizeof(Pixel), kColorType = PNG_COLOR_TYPE_GRAY;
};
template <>
struct PixelKind<RgbPixel> {
  static constexpr int kBits = 8, kColorType = PNG_COLOR_TYPE_RGB;
};

// Appends the stream of the rows. They have no filter: speckle gains nothing from one, and masks
// would store each change of value twice.
template <class Pixel>
void append_rows(std::span<const Pixel> pixels, std::size_t columns, std::string& out) {
  const std::size_t rows = pixels.size() / columns, row_bytes = 1 + columns * sizeof(Pixel);
  const auto bytes = std::make_unique_for_overwrite<std::uint8_t[]>(rows * row_bytes);
  for (std::size_t row = 0; row < rows; ++row) {
    bytes[row * row_bytes] = PNG_FILTER_VALUE_NONE;
    put_row(pixels.subspan(row * columns, columns), &bytes[row * row_bytes + 1]);
  }
  append_zlib({bytes.get(), rows * row_bytes}, out);
}

// With a palette, of red, green and blue bytes, the pixels are indices into it.
template <class Pixel>
Result<std::string> encode_pixels(std::span<const Pixel> pixels, int rows, int columns,
                                  std::string_view palette = {}) {
  ENSONIFY_ASSERT(rows > 0 && columns > 0);
  ENSONIFY_ASSERT(pixels.size() ==
                  static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  return without_exceptions("encoding a PNG image", [&]() -> Result<std::string> {
    std::string bytes(kStart.substr(0, 8));
    std::size_t chunk = begin_chunk(bytes, "IHDR");
    put_big_endian(bytes, static_cast<std::uint32_t>(columns));
    put_big_endian(bytes, static_cast<std::uint32_t>(rows));
    bytes += static_cast<char>(PixelKind<Pixel>::kBits);
    bytes +=
        static_cast<char>(palette.empty() ? PixelKind<Pixel>::kColorType : PNG_COLOR_TYPE_PALETTE);
    bytes.append(3, '\0');  // the only compression and filters there are; not interlaced
    end_chunk(bytes, chunk);
    if (!palette.empty()) {
      chunk = begin_chunk(bytes, "PLTE");
      bytes += palette;
      end_chunk(bytes, chunk);
    }
    chunk = begin_chunk(bytes, "IDAT");
    append_rows(pixels, static_cast<std::size_t>(columns), bytes);
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

// By default libpng reports errors with longjmp, which must not skip C++ destructors; these
// handlers throw instead.
[[noreturn]] void fail(png_structp, png_const_charp message) { throw std::runtime_error(message); }
void ignore(png_structp, png_const_charp) {}

void take_bytes(png_structp png, png_bytep out, png_size_t count) {
  auto& rest = *static_cast<std::string_view*>(png_get_io_ptr(png));
  if (count > rest.size()) throw std::runtime_error("it is cut off");
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
std::vector<Pixel> read_pixels(const Reader& reader, std::size_t rows, std::size_t columns) {
  if constexpr (sizeof(Pixel) == 2) png_set_swap(reader.png);
  const int passes = png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  std::vector<Pixel> pixels(rows * columns);
  for (int pass = 0; pass < passes; ++pass) {
    for (std::size_t row = 0; row < rows; ++row) {
      void* const begin = pixels.data() + row * columns;
      png_read_row(reader.png, static_cast<png_bytep>(begin), nullptr);
    }
  }
  png_read_end(reader.png, nullptr);
  return pixels;
}

// `rest` must outlive the reader's use.
void read_head(const Reader& reader, std::string_view& rest) {
  png_set_read_fn(reader.png, &rest, take_bytes);
  png_set_user_limits(reader.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
  png_read_info(reader.png, reader.info);
}

GreyPng read_image(std::string_view bytes) {
  Reader reader;
  std::string_view rest = bytes;
  read_head(reader, rest);
  GreyPng image;
  image.rows = png_get_image_height(reader.png, reader.info);
  image.columns = png_get_image_width(reader.png, reader.info);
  const std::size_t bits = png_get_bit_depth(reader.png, reader.info);
  if (png_get_color_type(reader.png, reader.info) != PNG_COLOR_TYPE_GRAY || bits < 8) {
    throw std::runtime_error("it is not a grayscale image of 8 or 16 bits");
  }
  if (std::uint64_t{image.rows} * image.columns / kMostInflation > bytes.size()) {
    throw std::runtime_error(kTooManyPixels);
  }
  if (bits == 8) {
    image.grey8 = read_pixels<std::uint8_t>(reader, image.rows, image.columns);
  } else {
    image.grey16 = read_pixels<std::uint16_t>(reader, image.rows, image.columns);
  }
  return image;
}

// Of an image whose header says 8-bit red, green and blue.
std::vector<RgbPixel> read_colors(std::string_view bytes) {
  Reader reader;
  std::string_view rest = bytes;
  read_head(reader, rest);
  const std::size_t rows = png_get_image_height(reader.png, reader.info);
  const std::size_t columns = png_get_image_width(reader.png, reader.info);
  if (std::uint64_t{rows} * columns * 3 / kMostInflation > bytes.size()) {
    throw std::runtime_error(kTooManyPixels);
  }
  return read_pixels<RgbPixel>(reader, rows, columns);
}

// Holds all values of the file only if they are interlaced.
template <class Pixel>
std::vector<float> brightness_of(const Reader& reader, std::size_t rows, std::size_t columns) {
  if constexpr (sizeof(Pixel) == 2) png_set_swap(reader.png);
  const int passes = png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  const std::size_t channels = png_get_channels(reader.png, reader.info);
  const std::size_t row_values = columns * channels;
  ENSONIFY_ASSERT(png_get_rowbytes(reader.png, reader.info) == row_values * sizeof(Pixel));
  const std::size_t colors = channels < 3 ? 1 : 3;  // the last of 2 and 4 is the opacity
  const double highest = static_cast<double>(colors) * std::numeric_limits<Pixel>::max();
  std::vector<Pixel> pixels((passes > 1 ? rows : 1) * row_values);
  std::vector<float> brightness;
  brightness.reserve(rows * columns);
  for (int pass = 0; pass < passes; ++pass) {
    for (std::size_t row = 0; row < rows; ++row) {
      Pixel* const line = pixels.data() + (passes > 1 ? row * row_values : 0);
      void* const bytes = line;
      png_read_row(reader.png, static_cast<png_bytep>(bytes), nullptr);
      if (pass + 1 < passes) continue;
      for (const Pixel* pixel = line; pixel < line + row_values; pixel += channels) {
        const double sum = std::accumulate(pixel, pixel + colors, 0.0);
        brightness.push_back(static_cast<float>(sum / highest));
      }
    }
  }
  png_read_end(reader.png, nullptr);
  return brightness;
}

BrightPng read_bright_image(std::string_view bytes) {
  Reader reader;
  std::string_view rest = bytes;
  read_head(reader, rest);
  BrightPng image;
  image.rows = png_get_image_height(reader.png, reader.info);
  image.columns = png_get_image_width(reader.png, reader.info);
  const std::uint64_t row_bytes = png_get_rowbytes(reader.png, reader.info);
  if (image.rows * row_bytes / kMostInflation > bytes.size()) {
    throw std::runtime_error(kTooManyPixels);
  }
  const bool is_palette = png_get_color_type(reader.png, reader.info) == PNG_COLOR_TYPE_PALETTE;
  const bool is_small = png_get_bit_depth(reader.png, reader.info) < 8;
  if (is_palette) png_set_palette_to_rgb(reader.png);
  if (is_small && !is_palette) png_set_expand_gray_1_2_4_to_8(reader.png);
  image.brightness = png_get_bit_depth(reader.png, reader.info) == 16
                         ? brightness_of<std::uint16_t>(reader, image.rows, image.columns)
                         : brightness_of<std::uint8_t>(reader, image.rows, image.columns);
  return image;
}

// Converts the exceptions of libpng's errors.
template <class Image>
Result<Image> parsed_png(std::string_view bytes, Image (*read)(std::string_view)) {
  try {
    return read(bytes);
  } catch (const std::runtime_error& error) {
    return Error{ErrorKind::usage, std::string("is not a readable PNG file: ") + error.what()};
  }
}

// Reads the pixels of one bit depth from a file of a data set.
template <class Pixel>
Result<std::vector<Pixel>> read_grey(const std::filesystem::path& path, std::uint64_t rows,
                                     std::uint64_t columns, std::vector<Pixel> GreyPng::*pixels) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const auto header = parse_png_header(*bytes);
  if (header && (header->height != rows || header->width != columns ||
                 header->bit_depth != 8 * sizeof(Pixel) || header->color_type != 0)) {
    return damaged(path, "does not have the size and bit depth given in sequence.json");
  }
  auto image = parse_grey_png(*bytes);
  if (!image) return damaged(path, image.error().message);
  return std::move((*image).*pixels);
}

}  // namespace

Result<std::string> encode_png(std::span<const std::uint8_t> pixels, int rows, int columns) {
  return encode_pixels(pixels, rows, columns);
}

Result<std::string> encode_png(std::span<const std::uint16_t> pixels, int rows, int columns) {
  return encode_pixels(pixels, rows, columns);
}

Result<std::string> encode_png(std::span<const RgbPixel> pixels, int rows, int columns) {
  return encode_pixels(pixels, rows, columns);
}

Result<std::string> encode_palette_png(std::span<const std::uint8_t> indices, int rows, int columns,
                                       const Palette& palette) {
  std::string colours;
  for (const auto& colour : palette) colours.append(colour.begin(), colour.end());
  return encode_pixels(indices, rows, columns, colours);
}

std::optional<PngHeader> parse_png_header(std::string_view bytes) {
  if (bytes.size() < 33 || bytes.substr(0, kStart.size()) != kStart) return std::nullopt;
  return PngHeader{big_endian(bytes.substr(16)), big_endian(bytes.substr(20)),
                   static_cast<unsigned char>(bytes[24]), static_cast<unsigned char>(bytes[25])};
}

Result<GreyPng> parse_grey_png(std::string_view bytes) { return parsed_png(bytes, read_image); }

Result<BrightPng> parse_bright_png(std::string_view bytes) {
  return parsed_png(bytes, read_bright_image);
}

Result<std::vector<std::uint8_t>> read_grey8(const std::filesystem::path& path, std::uint64_t rows,
                                             std::uint64_t columns) {
  return read_grey(path, rows, columns, &GreyPng::grey8);
}

Result<std::vector<std::uint16_t>> read_grey16(const std::filesystem::path& path,
                                               std::uint64_t rows, std::uint64_t columns) {
  return read_grey(path, rows, columns, &GreyPng::grey16);
}

Result<std::vector<std::uint8_t>> read_rgb8(const std::filesystem::path& path, std::uint64_t rows,
                                            std::uint64_t columns) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const auto header = parse_png_header(*bytes);
  if (!header || header->height != rows || header->width != columns || header->bit_depth != 8 ||
      header->color_type != PNG_COLOR_TYPE_RGB) {
    return damaged(path, "is not a PNG of 8-bit colors of the size given in sequence.json");
  }
  const auto pixels = parsed_png(*bytes, read_colors);
  if (!pixels) return damaged(path, pixels.error().message);
  std::vector<std::uint8_t> values;
  values.reserve(3 * pixels->size());
  for (const RgbPixel& pixel : *pixels) values.insert(values.end(), pixel.begin(), pixel.end());
  return values;
}

}  // namespace ensonify
