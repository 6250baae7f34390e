// JPEG files of others: pixels come back, and no header makes the reader allocate what the file
// cannot hold.
#include "formats/jpeg.h"

#include <cstddef>
#include <cstdio>
#include <cstdlib>
// clang-format off
#include <jpeglib.h>
// clang-format on

#include <algorithm>
#include <string>

#include "catch.h"
#include "results.h"

namespace ensonify {
namespace {

// A ramp along the columns, at the best quality.
std::string ramp_jpeg(unsigned rows, unsigned columns, int components,
                      const std::vector<jpeg_scan_info>& scans = {}) {
  jpeg_error_mgr errors{};
  jpeg_compress_struct state{};
  state.err = jpeg_std_error(&errors);
  jpeg_create_compress(&state);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&state, &bytes, &size);
  state.image_width = columns;
  state.image_height = rows;
  state.input_components = components;
  state.in_color_space = components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&state);
  jpeg_set_quality(&state, 100, TRUE);
  if (!scans.empty()) {
    state.scan_info = scans.data();
    state.num_scans = static_cast<int>(scans.size());
  }
  jpeg_start_compress(&state, TRUE);
  std::vector<unsigned char> line;
  for (unsigned c = 0; c < columns; ++c) {
    line.insert(line.end(), static_cast<std::size_t>(components),
                static_cast<unsigned char>(4 * c));
  }
  while (state.next_scanline < rows) {
    JSAMPROW row = line.data();
    jpeg_write_scanlines(&state, &row, 1);
  }
  jpeg_finish_compress(&state);
  jpeg_destroy_compress(&state);
  const void* const start = bytes;
  std::string text(static_cast<const char*>(start), size);
  std::free(bytes);
  return text;
}

}  // namespace

TEST_CASE("gray and color JPEG images have their luminance", "[jpeg]") {
  for (const int components : {1, 3}) {
    const auto image = value_of(parse_grey_jpeg(ramp_jpeg(24, 40, components)));
    CHECK(image.rows == 24);
    CHECK(image.columns == 40);
    REQUIRE(image.grey.size() == 24 * 40);
    for (std::size_t i = 0; i < image.grey.size(); ++i) {
      CHECK(std::abs(image.grey[i] - 4 * static_cast<int>(i % 40)) <= 2);
    }
  }
}

TEST_CASE("damaged JPEG images are errors", "[jpeg]") {
  const std::string whole = ramp_jpeg(64, 60, 1);
  for (std::size_t length = 0; length < whole.size() - 2; length += 7) {
    CHECK_FALSE(parse_grey_jpeg(whole.substr(0, length)).ok());
  }
  CHECK_FALSE(parse_grey_jpeg("\x89PNG").ok());
}

TEST_CASE("a JPEG header cannot claim more pixels than the file holds", "[jpeg]") {
  std::string bytes = ramp_jpeg(8, 8, 1);
  const std::size_t frame = bytes.find("\xff\xc0");
  REQUIRE(frame != std::string::npos);
  for (std::size_t i = 5; i < 9; ++i) bytes[frame + i] = '\x7f';  // rows and columns
  check_fails(parse_grey_jpeg(bytes), {"more pixels than it holds"});
}

// Protects memory and time: an image of another size is refused before it is decoded.
TEST_CASE("JPEG images of another size or in color are refused by their header", "[jpeg]") {
  const std::string gray = ramp_jpeg(64, 60, 1);
  CHECK(parse_grey_jpeg(gray, JpegSize{64, 60}).ok());
  const auto error_of = [](const std::string& bytes, const JpegSize& expected) {
    return message_of(parse_grey_jpeg(bytes, expected));
  };
  // Nothing follows the header: that of another size is not missed.
  const std::string header = gray.substr(0, gray.find("\xff\xda") + 12);
  for (const std::string& bytes : {gray, header}) {
    for (const JpegSize& other : {JpegSize{60, 64}, JpegSize{64, 61}, JpegSize{63, 60}}) {
      CHECK(contains(error_of(bytes, other), "it has 64 x 60 pixels of 1"));
    }
  }
  CHECK_FALSE(contains(error_of(header, {64, 60}), "it has"));
  CHECK(contains(error_of(ramp_jpeg(64, 60, 3), {64, 60}), "of 3 components"));
}

// Protects against files whose few bytes take hours: each scan passes over all pixels.
TEST_CASE("images of many scans are refused", "[jpeg]") {
  std::vector<jpeg_scan_info> scans = {{1, {0}, 0, 0, 0, 1}, {1, {0}, 0, 0, 1, 0}};
  for (int k = 1; k < 64; ++k) scans.push_back({1, {0}, k, k, 0, 1});
  CHECK(parse_grey_jpeg(ramp_jpeg(24, 40, 1, scans)).ok());
  for (int k = 1; k < 64; ++k) scans.push_back({1, {0}, k, k, 1, 0});
  check_fails(parse_grey_jpeg(ramp_jpeg(24, 40, 1, scans)), {"more than 100 scans"});
}

// Protects renders as JPEG: rows and columns in their places, and the quality.
TEST_CASE("encoded JPEG images come back", "[jpeg]") {
  std::vector<std::uint8_t> pixels;
  for (int row = 0; row < 21; ++row) {
    for (int column = 0; column < 35; ++column) {
      pixels.push_back(static_cast<std::uint8_t>(10 * row + column));
    }
  }
  std::size_t size = 0;
  for (const int quality : {1, 50, 100}) {
    const auto bytes = value_of(encode_grey_jpeg(pixels, 21, 35, quality));
    CHECK(bytes.size() > size);
    size = bytes.size();
    const auto image = value_of(parse_grey_jpeg(bytes));
    CHECK(image.rows == 21);
    REQUIRE(image.columns == 35);
    if (quality < 100) continue;
    int worst = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      worst = std::max(worst, std::abs(int{image.grey[i]} - int{pixels[i]}));
    }
    CHECK(worst <= 2);
  }
}

TEST_CASE("an image with a side that JPEG cannot have is an error", "[jpeg]") {
  const std::vector<std::uint8_t> wide(70'000);
  check_fails(encode_grey_jpeg(wide, 1, 70'000, 95), {"cannot be a JPEG file"});
}

}  // namespace ensonify
