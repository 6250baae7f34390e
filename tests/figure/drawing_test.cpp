// Drawings as pixels and as SVG.
#include "figure/drawing.h"

#include "catch.h"
#include "figure/compose.h"
#include "results.h"

using namespace ensonify;

namespace {

Drawing drawing_with(const std::string& words) {
  Drawing drawing{60, 40, {}};
  RgbImage picture(2, 1, Rgb8{10, 20, 30});
  picture.set(1, Rgb8{200, 100, 50});
  drawing.items.emplace_back(DrawnBox{0, 0, 10, 10, Rgb8{0, 255, 0}});
  drawing.items.emplace_back(DrawnPicture{30, 5, picture});
  drawing.items.emplace_back(DrawnText{20, 30, words, 8, Anchor::middle, true, Rgb8{}});
  return drawing;
}

std::string svg_of(const Drawing& drawing) { return value_of(encode_svg(drawing)); }

std::vector<std::string> texts_of(const Drawing& drawing) {
  std::vector<std::string> texts;
  for (const auto& item : drawing.items) {
    if (const auto* text = std::get_if<DrawnText>(&item)) texts.push_back(text->text);
  }
  return texts;
}

bool holds(const std::vector<std::string>& texts, const std::string& text) {
  return std::find(texts.begin(), texts.end(), text) != texts.end();
}

}  // namespace

TEST_CASE("a raster has each item in its place") {
  const auto image = value_of(draw_raster(drawing_with("x")));
  CHECK(image.width == 60);
  CHECK(image.height == 40);
  CHECK(image.at(5, 5) == Rgb8{0, 255, 0});
  CHECK(image.at(30, 5) == Rgb8{10, 20, 30});
  CHECK(image.at(31, 5) == Rgb8{200, 100, 50});
  CHECK(image.at(32, 5) == Rgb8{255, 255, 255});
}

// Protects against names that are written by strangers.
TEST_CASE("names stay texts in SVG") {
  const std::string svg = svg_of(drawing_with("<script>\"a\" & 'b'\x01]]>\xef\xbf\xbe"));
  CHECK_FALSE(contains(svg, "<script"));
  CHECK(
      contains(svg, "&lt;script&gt;&quot;a&quot; &amp; 'b'\xef\xbf\xbd]]&gt;\xef\xbf\xbd</text>"));
  CHECK(contains(svg, "transform=\"rotate(-90 20 30)\""));
  CHECK(contains(svg, "text-anchor=\"middle\""));
  CHECK(contains(svg, "xlink:href=\"data:image/png;base64,iVBORw0KGgo"));
  CHECK(svg == svg_of(drawing_with("<script>\"a\" & 'b'\x01]]>\xef\xbf\xbe")));
}

TEST_CASE("axes carry metres, degrees and units") {
  Surroundings around;
  around.fan = {-0.5, 0.1, 0, 0.05, 11, 200};  // 63 degrees, 10 m
  around.bar = ColourBar{"level (dB)", find_colour_map("viridis"), {50, 110}};
  around.legend = {{Rgb8{1, 2, 3}, "ball"}};
  const Layout layout = layout_of(around, 900);
  CHECK(layout.width == 900);
  CHECK(layout.height % 2 == 0);
  // Metres are as long to port as ahead.
  CHECK(layout.picture_width / (layout.extent.left - layout.extent.right) ==
        Approx(layout.picture_height / (layout.extent.top - layout.extent.bottom)).epsilon(0.01));
  const Drawing drawing = compose(
      layout, around, RgbImage(layout.picture_width, layout.picture_height, Rgb8{}), "A title");
  const auto texts = texts_of(drawing);
  for (const char* text : {"A title", "ahead (m)", "to port (m)", "0", "2", "8", "15\xc2\xb0",
                           "\xe2\x88\x92"
                           "15\xc2\xb0",
                           "\xe2\x88\x92"
                           "4",
                           "level (dB)", "60", "110", "ball"}) {
    INFO(text);
    CHECK(holds(texts, text));
  }
  // Port is on the left: 4 m to port lies left of 4 m to starboard.
  double port = 0, starboard = 0, zero = 0;
  const double axis_y = layout.top + layout.picture_height;
  for (const auto& item : drawing.items) {
    const auto* text = std::get_if<DrawnText>(&item);
    if (text == nullptr || text->y < axis_y || text->anchor != Anchor::middle) continue;
    if (text->text == "4") port = text->x;
    if (text->text == "0") zero = text->x;
    if (text->text ==
        "\xe2\x88\x92"
        "4")
      starboard = text->x;
  }
  CHECK(zero == Approx(layout.left + layout.picture_width / 2.0).margin(1));
  const double metre = layout.picture_width / (layout.extent.left - layout.extent.right);
  CHECK(zero - port == Approx(4 * metre).margin(0.5));
  CHECK(starboard - zero == Approx(4 * metre).margin(0.5));

  around.view = StoredView::polar;
  const Layout polar = layout_of(around, 900);
  const auto polar_texts = texts_of(
      compose(polar, around, RgbImage(polar.picture_width, polar.picture_height, Rgb8{}), ""));
  CHECK(holds(polar_texts, "slant range (m)"));
  CHECK(holds(polar_texts, "azimuth (\xc2\xb0), positive to port"));
  CHECK(holds(polar_texts, "20"));
  CHECK_FALSE(holds(polar_texts, "A title"));
}

TEST_CASE("nothing leaves the figure") {
  Surroundings around;
  around.fan =
      GENERATE(PolarFan{-0.1, 0.01, 0, 0.05, 21, 400}, PolarFan{-2.8, 0.1, 0, 0.05, 57, 400},
               PolarFan{-0.75, 0.003, 0, 0.05, 500, 900}, PolarFan{0, 0.02, 0, 0.5, 1, 40});
  around.view = GENERATE(StoredView::cartesian, StoredView::polar);
  for (int i = 0; i < GENERATE(0, 3, 40); ++i) {
    around.legend.push_back(
        {id_colour(7), "a name of more letters than a column holds " + std::to_string(i)});
  }
  if (GENERATE(true, false)) {
    around.bar = ColourBar{"level (dB re 1 \xc2\xb5Pa)", find_colour_map("grey"), {-120, -60}};
  }
  const Layout layout = layout_of(around, GENERATE(200, 1200));
  const Drawing drawing =
      compose(layout, around, RgbImage(layout.picture_width, layout.picture_height, Rgb8{}),
              std::string(300, 'W'));
  for (const auto& item : drawing.items) {
    if (const auto* p = std::get_if<DrawnPicture>(&item)) {
      CHECK((p->x >= 0 && p->y >= 0));
      CHECK((p->x + p->image.width <= layout.width && p->y + p->image.height <= layout.height));
    }
    if (const auto* t = std::get_if<DrawnText>(&item)) {
      INFO(t->text << " at " << t->x << ", " << t->y << " of " << layout.width << " x "
                   << layout.height);
      CHECK((t->x >= 0 && t->x <= layout.width && t->y >= t->size / 2));
      CHECK(t->y <= layout.height - 0.1 * t->size);
    }
    if (const auto* b = std::get_if<DrawnBox>(&item)) {
      CHECK((b->x >= 0 && b->x + b->width <= layout.width && b->y + b->height <= layout.height));
    }
  }
}
