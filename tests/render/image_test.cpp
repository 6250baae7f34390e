#include "render/shown_images.h"

#include "catch.h"
#include "figure/drawing.h"
#include "formats/png.h"
#include "render/shown_images.h"
#include "results.h"

using namespace ensonify;

namespace {

const GreyImage kImage{2, 3, {1, 2, 3, 4, 5, 6}};

}  // namespace

TEST_CASE("images are flipped by columns, rows or both") {
  CHECK(flipped(kImage, Flip::none).pixels == kImage.pixels);
  CHECK(flipped(kImage, Flip::horizontal).pixels == std::vector<std::uint8_t>{3, 2, 1, 6, 5, 4});
  CHECK(flipped(kImage, Flip::vertical).pixels == std::vector<std::uint8_t>{4, 5, 6, 1, 2, 3});
  CHECK(flipped(kImage, Flip::both).pixels == std::vector<std::uint8_t>{6, 5, 4, 3, 2, 1});
}

TEST_CASE("a map shows polar pixels, and black outside the fan") {
  const std::vector<std::int32_t> map = {5, -1, 0, 0};
  CHECK(mapped(kImage, map, 2, 2).pixels == std::vector<std::uint8_t>{6, 0, 1, 1});
}

// Protects who reads the pixels of a colored render as gray levels: they are the indices, and the
// palette is that of the color map.
TEST_CASE("colors are a palette over the gray levels") {
  Display display;
  display.color_map = "magma";
  const auto png = value_of(encode_image(kImage, display));
  const auto header = value_of(parse_png_header(png));
  CHECK(header.color_type == 3);
  const std::size_t palette = png.find("PLTE") + 4;
  for (const std::size_t k : {0, 8, 100, 255}) {
    const Rgb8 color = colour_at(*find_colour_map("magma"), static_cast<double>(k) / 255);
    CHECK(static_cast<std::uint8_t>(png[palette + 3 * k]) == color.red);
    CHECK(static_cast<std::uint8_t>(png[palette + 3 * k + 2]) == color.blue);
  }
  CHECK(*encode_image(kImage, {}) == *encode_png(kImage.pixels, 2, 3));
}

// Protects users from white and black images that nobody mentions, and from warnings of good ones.
TEST_CASE("a display that does not fit its levels is warned of") {
  CHECK(display_warning({}, {1000, 10, 100, 90}, "out").empty());
  CHECK(display_warning({}, {}, "out").empty());
  const std::string white = display_warning({}, {1000, 11, 100, 90}, "out");
  CHECK(contains(white, "1.1 % of the pixels are white with limits of 60 and 120 dB"));
  CHECK(contains(white, "`ensonify render out --name"));
  CHECK(contains(display_warning({}, {1000, 0, 100, 91}, "out"),
                 "91.0 % of the pixels with echoes are black"));
}
