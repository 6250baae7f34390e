#include "formats/png.h"

#include <png.h>

#include <cstring>
#include <numeric>
#include <random>
#include <vector>

#include "catch.h"
#include "results.h"

using namespace ensonify;

namespace {

struct Decoded {
  png_uint_32 width = 0, height = 0;
  int bit_depth = 0, color_type = 0;
  std::vector<std::uint16_t> pixels;
};

struct Source {
  const std::string& bytes;
  std::size_t position = 0;
};

void read_bytes(png_structp png, png_bytep out, std::size_t size) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (source->position + size > source->bytes.size()) png_error(png, "end of file");
  std::memcpy(out, source->bytes.data() + source->position, size);
  source->position += size;
}

Decoded decode(const std::string& bytes) {
  Decoded image;
  Source source{bytes};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_read_fn(png, &source, read_bytes);
  png_read_info(png, info);
  png_get_IHDR(png, info, &image.width, &image.height, &image.bit_depth, &image.color_type, nullptr,
               nullptr, nullptr);
  const std::size_t bytes_each = image.bit_depth == 16 ? 2 : 1;
  std::vector<png_byte> row(image.width * bytes_each);
  for (png_uint_32 y = 0; y < image.height; ++y) {
    png_read_row(png, row.data(), nullptr);
    for (png_uint_32 x = 0; x < image.width; ++x) {
      const unsigned high = bytes_each == 2 ? row[2 * x] * 256u : 0u;  // PNG is big-endian
      image.pixels.push_back(
          static_cast<std::uint16_t>(high + row[bytes_each * x + bytes_each - 1]));
    }
  }
  png_destroy_read_struct(&png, &info, nullptr);
  return image;
}

}  // namespace

// Protects instance ids: 16 bits, exact, in the right byte order and orientation.
TEST_CASE("a 16-bit mask reads back exactly") {
  std::vector<std::uint16_t> ids(5 * 300);
  std::iota(ids.begin(), ids.end(), std::uint16_t{64034});
  ids[7] = 65534;
  ids[8] = 0;
  const auto bytes = value_of(encode_png(ids, 5, 300));
  const Decoded image = decode(bytes);
  CHECK(image.width == 300);
  CHECK(image.height == 5);
  CHECK(image.bit_depth == 16);
  CHECK(image.color_type == PNG_COLOR_TYPE_GRAY);
  CHECK(image.pixels == ids);
}

// Protects the 8-bit pictures.
TEST_CASE("an 8-bit picture reads back exactly") {
  std::vector<std::uint8_t> pixels(40 * 11);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i * 89);
  const auto bytes = value_of(encode_png(pixels, 40, 11));
  const Decoded image = decode(bytes);
  CHECK(image.bit_depth == 8);
  CHECK(image.pixels == std::vector<std::uint16_t>(pixels.begin(), pixels.end()));
}

// Protects masks of any content and several blocks: noise, one value, every id, objects on nothing.
TEST_CASE("large masks read back exactly") {
  constexpr int kLargeRows = 300, kLargeColumns = 257;
  std::vector<std::uint16_t> ids(kLargeRows * kLargeColumns);
  std::mt19937 random(1);
  SECTION("noise") {
    for (auto& id : ids) id = static_cast<std::uint16_t>(random());
  }
  SECTION("nothing") {}
  SECTION("one id, two different bytes") { ids.assign(ids.size(), 0x1234); }
  SECTION("largest id") { ids.assign(ids.size(), 65535); }
  SECTION("every id") { std::iota(ids.begin(), ids.end(), std::uint16_t{0}); }
  SECTION("objects") {
    for (std::size_t i = 0; i < ids.size(); ++i) {
      ids[i] = i % kLargeColumns / 50 == 2 ? static_cast<std::uint16_t>(300 + i / 9000) : 0;
    }
  }
  const auto bytes = value_of(encode_png(ids, kLargeRows, kLargeColumns));
  CHECK((decode(bytes).pixels == ids));

  const std::vector<std::uint8_t> low(ids.begin(), ids.end());
  const auto low_bytes = value_of(encode_png(low, kLargeRows, kLargeColumns));
  CHECK((decode(low_bytes).pixels == std::vector<std::uint16_t>(low.begin(), low.end())));
}

// Protects the promise of equal bytes: no time stamp or other text chunk is in the file.
TEST_CASE("a PNG file holds the picture and nothing else") {
  const auto bytes = value_of(encode_png(std::vector<std::uint8_t>(12), 3, 4));
  std::string chunks;
  for (std::size_t at = 8; at + 12 <= bytes.size();) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[at + i]); };
    const std::size_t length = byte(0) << 24 | byte(1) << 16 | byte(2) << 8 | byte(3);
    chunks += bytes.substr(at + 4, 4) + " ";
    at += length + 12;
  }
  CHECK(chunks == "IHDR IDAT IEND ");
}

// Protects masks with colours of their own: readers must get the indices, and find the colours.
TEST_CASE("indices read back with their palette") {
  Palette palette{};
  palette[255] = {10, 20, 30};
  std::vector<std::uint8_t> indices(40 * 11);
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<std::uint8_t>(i / 7);
  const auto bytes = value_of(encode_palette_png(indices, 40, 11, palette));
  const Decoded image = decode(bytes);
  CHECK(image.color_type == PNG_COLOR_TYPE_PALETTE);
  CHECK(image.pixels == std::vector<std::uint16_t>(indices.begin(), indices.end()));
  const std::size_t colours = bytes.find("PLTE") + 4;
  CHECK(bytes.substr(colours + 3 * 255, 3) == "\x0a\x14\x1e");
}

// Protects memory: a header may claim what no file of this length can hold.
TEST_CASE("a PNG file that claims more pixels than it has is refused") {
  auto bytes = value_of(encode_png(std::vector<std::uint8_t>(12), 3, 4));
  REQUIRE(parse_grey_png(bytes).ok());
  CHECK(parse_grey_png(bytes)->grey8 == std::vector<std::uint8_t>(12));
  std::string claim = "IHDR" + std::string("\0\1\0\0\0\1\0\0", 8) + std::string("\x8\0\0\0\0", 5);
  const std::uint32_t checksum = crc32_of(claim);
  for (int shift = 24; shift >= 0; shift -= 8) claim += static_cast<char>(checksum >> shift & 255);
  bytes.replace(12, claim.size(), claim);
  check_fails(parse_grey_png(bytes), {"more pixels than it holds"});
}

// Protects verify's look at sizes and bit depths.
TEST_CASE("a PNG header reads back") {
  const auto bytes = value_of(encode_png(std::vector<std::uint16_t>(12), 3, 4));
  const auto header = value_of(parse_png_header(bytes));
  CHECK(header.width == 4);
  CHECK(header.height == 3);
  CHECK(header.bit_depth == 16);
  CHECK(header.color_type == 0);
  CHECK_FALSE(parse_png_header("\x89PNG"));
}
