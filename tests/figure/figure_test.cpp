// Figures of a data set whose levels are known, decoded again.
#include "figure/figure.h"

#include <png.h>

#include <cmath>
#include <filesystem>
#include <functional>

#include "catch.h"
#include "core/units.h"
#include "dataset/sample.h"
#include "dataset/write_ping.h"
#include "figure/frames.h"
#include "results.h"

using namespace ensonify;
namespace fs = std::filesystem;

namespace {

constexpr int kRow = 7, kColumn = 4;  // of the target: to port
constexpr float kTargetDb = 100, kFloorDb = 60;

SequenceInfo sequence_info(bool packed) {
  SequenceInfo info = sample::sequence_info(0);
  info.output.timeseries_exr = false;
  info.output.packed = packed;
  info.instances[1].name = "<ball> & \"net\"";
  return info;
}

// 60 dB everywhere, and a target of 100 dB in one cell.
PingResult ping_result(const SequenceInfo& info, std::uint32_t ping) {
  PingResult result = sample::ping_result(info, ping);
  LabelledImage& image = *result.polar;
  for (std::size_t i = 0; i < image.level_db.size(); ++i) {
    const bool target = i == kRow * sample::kBeams + kColumn;
    image.level_db[i] = target ? kTargetDb : kFloorDb;
    image.clean_db[i] = image.level_db[i] - 5;
    image.elevation_rad[i] = target ? 0.1f : -0.1f;
    image.instance[i] = target ? 2 : 0;
    image.semantic[i] = target ? 2 : 0;
    image.shadow[i] = 0;
  }
  return result;
}

struct Made {
  explicit Made(bool packed = false, int wall_beams = 0) {
    const fs::path dir = folder.path() / "set";
    fs::create_directory(dir);
    DatasetInfo all = sample::dataset_info(1);
    const SequenceInfo info = all.first = sequence_info(packed);
    sample::open(dir, 1);
    const Workers workers(2);
    for (std::uint32_t ping = 0; ping < sample::kPings; ++ping) {
      PingResult result = ping_result(info, ping);
      for (int j = 0; j < wall_beams; ++j) result.polar->instance[2 * sample::kBeams + j] = 1;
      REQUIRE(write_ping(dir, info, result, workers).ok());
    }
    REQUIRE(sample::finish(dir, info).ok());
    REQUIRE(finish_dataset(dir, all).ok());
  }

  FigureOptions options(const std::string& name) const {
    FigureOptions o;
    o.dataset = folder.path() / "set";
    o.output = folder.path() / name;
    o.width_px = 600;
    o.db = {40, 110};
    return o;
  }
  std::string draw(const FigureOptions& o) const {
    value_of(write_figure(o));
    const std::string bytes = sample::read(o.output);
    fs::remove(o.output);
    return bytes;
  }
  Error refusal(const FigureOptions& o) const {
    const auto report = write_figure(o);
    REQUIRE_FALSE(report.ok());
    CHECK_FALSE(fs::exists(o.output));
    CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
    return report.error();
  }

  sample::TemporaryFolder folder;
};

RgbImage decode_png(const std::string& bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) != 0);
  png.format = PNG_FORMAT_RGB;
  RgbImage image(static_cast<int>(png.width), static_cast<int>(png.height), Rgb8{});
  REQUIRE(png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr) != 0);
  return image;
}

Layout layout_for(const FigureOptions& o) {
  return value_of(FrameMaker::open(value_of(choose(o)), o)).layout();
}

// Colour of the centre of a cell; columns from the other side are its mirror image.
Rgb8 colour_of(const RgbImage& image, const Layout& l, int row, int column) {
  const SequenceInfo info = sequence_info(false);
  const double range = row * 1500 / (2 * 29.9e3);
  const double azimuth = (column - (sample::kBeams - 1) / 2.0) * info.sonar.beam_spacing_rad;
  const double port = range * std::sin(azimuth), ahead = range * std::cos(azimuth);
  const Extent& e = l.extent;
  return image.at(
      l.left + static_cast<int>((e.left - port) / (e.left - e.right) * l.picture_width),
      l.top + static_cast<int>((e.top - ahead) / (e.top - e.bottom) * l.picture_height));
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

}  // namespace

// Protects the whole way from the file to the pixel: range, side, level and colour.
TEST_CASE("a target has the colour of its level in its place") {
  const Made made(GENERATE(false, true));
  FigureOptions o = made.options("f.png");
  o.colour_map = GENERATE("viridis", "grey");
  const RgbImage image = decode_png(made.draw(o));
  const Layout l = layout_for(o);
  CHECK(image.width == 600);
  CHECK(image.height == l.height);
  const ColourMap& map = *find_colour_map(o.colour_map);
  CHECK(colour_of(image, l, kRow, kColumn) == colour_at(map, (kTargetDb - 40) / 70));
  CHECK(colour_of(image, l, kRow, sample::kBeams - 1 - kColumn) ==
        colour_at(map, (kFloorDb - 40) / 70));
  // To port is left of the middle.
  FigureOptions clean = o;
  clean.quantity = FigureQuantity::clean;
  CHECK(colour_of(decode_png(made.draw(clean)), l, kRow, kColumn) ==
        colour_at(map, (kTargetDb - 5 - 40) / 70));
}

TEST_CASE("a polar figure has beam 0 on the left and range 0 on top") {
  const Made made;
  FigureOptions o = made.options("f.png");
  o.view = FigureView::polar;
  o.colour_map = "grey";
  const RgbImage image = decode_png(made.draw(o));
  const Layout l = layout_for(o);
  const auto at = [&](double row, double column) {
    return image.at(l.left + static_cast<int>((column + 0.5) / sample::kBeams * l.picture_width),
                    l.top + static_cast<int>(row / (sample::kSamples - 0.5) * l.picture_height));
  };
  const ColourMap& map = *find_colour_map("grey");
  CHECK(at(kRow, kColumn) == colour_at(map, (kTargetDb - 40) / 70));
  CHECK(at(kRow, 1) == colour_at(map, (kFloorDb - 40) / 70));
  CHECK(at(1, kColumn) == colour_at(map, (kFloorDb - 40) / 70));
}

TEST_CASE("masks, elevation and outlines") {
  const Made made;
  FigureOptions o = made.options("f.png");
  o.db.reset();
  SECTION("of instances and classes") {
    o.quantity = GENERATE(FigureQuantity::instance, FigureQuantity::semantic);
    const RgbImage image = decode_png(made.draw(o));
    const Layout l = layout_for(o);
    CHECK(colour_of(image, l, kRow, kColumn) == id_colour(2));
    CHECK(colour_of(image, l, kRow, 1) == kNoIdColour);
  }
  SECTION("of instances that were not chosen") {
    o.quantity = FigureQuantity::instance;
    o.instances = {"wall"};
    CHECK(colour_of(decode_png(made.draw(o)), layout_for(o), kRow, kColumn) == kNoIdColour);
  }
  SECTION("elevation in degrees") {
    o.quantity = FigureQuantity::elevation;
    const RgbImage image = decode_png(made.draw(o));
    const Layout l = layout_for(o);
    const ColourMap& map = *find_colour_map("viridis");
    // From -7 to -4: all but one cell are at -0.1 rad, as a half.
    CHECK(colour_of(image, l, kRow, kColumn) == colour_at(map, 1));
    CHECK(colour_of(image, l, kRow, 1) == colour_at(map, (7 - degrees(0.0999755859375)) / 3));
  }
  SECTION("outlines are drawn over the level") {
    o.db = {40, 110};
    o.outlines = true;
    const RgbImage image = decode_png(made.draw(o));
    std::size_t rim = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) rim += image.at(x, y) == id_colour(2);
    }
    CHECK(rim > 100);
    o.instances = {"wall"};
    const RgbImage none = decode_png(made.draw(o));
    CHECK(colour_of(none, layout_for(o), kRow, kColumn) ==
          colour_at(*find_colour_map("inferno"), (kTargetDb - 40) / 70));
    CHECK_FALSE(colour_of(image, layout_for(o), kRow, kColumn) == id_colour(2));
  }
}

// Protects pictures from outlines that cover them.
TEST_CASE("a mask over more than half of the beams is outlined where it is named alone") {
  const Made made(false, 4);
  FigureOptions o = made.options("f.svg");
  o.outlines = true;
  CHECK(count(made.draw(o), ">wall</text>") == 0);
  CHECK(count(made.draw(o), "net&quot;</text>") == 1);
  o.instances = {"wall"};
  CHECK(count(made.draw(o), ">wall</text>") == 1);
  const Made narrow(false, 3);
  o = narrow.options("f.svg");
  o.outlines = true;
  CHECK(count(narrow.draw(o), ">wall</text>") == 1);
}

TEST_CASE("SVG holds names as texts and the same bytes every time") {
  const Made made;
  FigureOptions o = made.options("f.svg");
  o.outlines = true;
  const std::string svg = made.draw(o);
  CHECK(svg == made.draw(o));
  CHECK(contains(svg, ">&lt;ball&gt; &amp; &quot;net&quot;</text>"));
  CHECK(contains(svg, ">tank, ping 0, 0.00 s</text>"));
  CHECK_FALSE(contains(svg, "<ball>"));
  CHECK(svg.find(">wall</text>") == std::string::npos);  // it is not in the picture
  o.title = "Fig. 3";
  o.ping = 2;
  const std::string titled = made.draw(o);
  CHECK(contains(titled, ">Fig. 3</text>"));
  CHECK_FALSE(contains(titled, "ping 2"));
  o.output.replace_extension(".png");
  CHECK(made.draw(o) == made.draw(o));
}

TEST_CASE("an animation has a frame a ping") {
  const Made made;
  FigureOptions o = made.options("f.webp");
  const std::string all = made.draw(o);
  CHECK(all.substr(0, 4) == "RIFF");
  CHECK(count(all, "ANMF") == 3);
  CHECK(all == made.draw(o));
  o.pings = {1, 3};
  o.fps = 4;
  const std::string two = made.draw(o);
  CHECK(count(two, "ANMF") == 2);
  // Duration of the first frame, ms: behind place and size in its chunk.
  const std::size_t frame = two.find("ANMF") + 8 + 12;
  CHECK((static_cast<unsigned char>(two.at(frame)) | static_cast<unsigned char>(two.at(frame + 1))
                                                         << 8) == 250);
}

TEST_CASE("the data's own limits are told") {
  const Made made;
  FigureOptions o = made.options("f.png");
  o.db.reset();
  const auto report = value_of(write_figure(o));
  REQUIRE(report.limits);
  CHECK((*report.limits)[0] < kFloorDb - 5);
  CHECK((*report.limits)[1] - (*report.limits)[0] >= 40);
  CHECK(report.frames == 1);
}

TEST_CASE("wrong options are told with what there is") {
  const Made made;
  const auto animated = [&](FigureOptions& o) { o.output = made.folder.path() / "f.webp"; };
  const struct {
    std::function<void(FigureOptions&)> change;
    const char* told;
  } cases[] = {
      {[&](auto& o) { o.output = made.folder.path() / "f.jpg"; }, ".png, .svg, .webp or .mp4"},
      {[](auto& o) { o.sequence = 1; }, "has only sequence 0"},
      {[](auto& o) { o.ping = 3; }, "has pings 0 to 2"},
      {[](auto& o) { o.colour_map = "jet"; }, "cividis, viridis"},
      {[](auto& o) { o.outlines = true, o.instances = {"bal"}; }, "wall, <ball>"},
      {[](auto& o) {
         o.pings = {0, 2};
       },
       "--pings is for"},
      {[](auto& o) {
         o.db = {50, 50};
       },
       "lower limit comes first"},
      {[](auto& o) { o.quantity = FigureQuantity::semantic; }, "level and clean"},
      {[&](auto& o) { animated(o), o.ping = 1; }, "takes --pings"},
      {[&](auto& o) {
         animated(o), o.pings = {2, 4};
       },
       "has pings 0 to 2"},
      {[&](auto& o) { animated(o), o.fps = 0; }, "0.1 to 60"},
      {[](auto& o) { o.width_px = 100; }, "200 to 8000"},
      {[&](auto& o) { o.dataset = made.folder.path() / "none"; }, "no such folder"},
      {[&](auto& o) { o.output = made.folder.path() / "set/f.png"; }, "lies in the data set"},
      {[](auto& o) { o.outlines = true, o.quantity = FigureQuantity::instance, o.db.reset(); },
       "a mask shows the same"},
  };
  for (const auto& [change, told] : cases) {
    FigureOptions o = made.options("f.png");
    change(o);
    const Error error = made.refusal(o);
    INFO(error.message);
    CHECK(error.kind == ErrorKind::usage);
    CHECK(contains(error.message, told));
  }
}

TEST_CASE("what is there is replaced only where that is asked for") {
  const Made made;
  FigureOptions o = made.options("f.png");
  sample::write(o.output, "mine");
  CHECK_FALSE(write_figure(o).ok());
  CHECK(sample::read(o.output) == "mine");
  o.overwrite = true;
  CHECK(write_figure(o).ok());
  CHECK(sample::read(o.output) != "mine");
}

TEST_CASE("an interrupted animation leaves nothing") {
  const Made made;
  FigureOptions o = made.options("f.webp");
  o.stop = [] { return true; };
  CHECK(made.refusal(o).kind == ErrorKind::interrupted);
}

TEST_CASE("damaged pictures are told") {
  const Made made;
  const fs::path picture = made.folder.path() / "set/sequences/000000/polar/000001.exr";
  fs::resize_file(picture, 100);
  FigureOptions o = made.options("f.webp");
  const Error error = made.refusal(o);
  CHECK(error.kind == ErrorKind::io);
  CHECK(contains(error.message, "000001.exr"));
}
