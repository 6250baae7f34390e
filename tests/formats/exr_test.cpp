#include "dataset/image_exr.h"

#include "formats/bytes.h"

#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "catch.h"
#include "core/front_planes.h"
#include "core/image_planes.h"
#include "dataset/sample.h"
#include "results.h"

using namespace ensonify;

namespace {

constexpr int kRows = 5, kColumns = 4;
const ExrAttributes kAttributes = {{{"axes", "rows: samples"}}, {{"metres_per_pixel", 1.0 / 3}}};

std::string encode(const LabelledImage& image) { return value_of(encode_exr(image, kAttributes)); }

std::vector<half> read_channel(Imf::MultiPartInputFile& file, int part, const char* channel) {
  const auto window = file.header(part).dataWindow();
  const auto columns = static_cast<std::size_t>(window.max.x + 1);
  std::vector<half> pixels(columns * static_cast<std::size_t>(window.max.y + 1));
  Imf::FrameBuffer frame;
  frame.insert(channel, Imf::Slice::Make(Imf::HALF, pixels.data(), window));
  Imf::InputPart input(file, part);
  input.setFrameBuffer(frame);
  input.readPixels(0, window.max.y);
  return pixels;
}

// The planes of the second part, in the order of the table.
std::vector<const ImagePlane*> labels_of_exr() {
  std::vector<const ImagePlane*> planes;
  for (const ImagePlane& plane : kImagePlanes) {
    const bool is_level = std::string_view(plane.name) == "level_db";
    const bool is_surface = has_own_file(plane);
    if (plane.values.index() == 0 && !is_level && !is_surface) planes.push_back(&plane);
  }
  return planes;
}

template <class Image>
auto& floats_of(Image& image, const ImagePlane& plane) {
  return image.*std::get<std::vector<float> ImagePlanes::*>(plane.values);
}

// One alone and eight together go different ways, and must come to the same.
std::uint16_t to_half(float value) {
  std::array<float, 9> values;
  values.fill(value);
  std::array<std::uint16_t, 9> bits{};
  to_halves(values, bits);
  if (std::count(bits.begin(), bits.end(), bits[8]) != 9) throw std::logic_error("not alike");
  return bits[8];
}

// By Imath, which knows nothing of our limits.
std::uint16_t expected_half(float value) {
  if (std::isnan(value)) return half::qNan().bits();
  return half(std::clamp(value, -65504.0f, 65504.0f)).bits();
}

}  // namespace

// Protects what viewers and cv2 rely on: `level` first, channel Y alone in it, uncompressed; labels
// behind it under their names; all of them half.
TEST_CASE("an EXR picture has its parts, channels and compressions") {
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / "a.exr", encode(sample::image(kRows, kColumns, 0)));
  Imf::MultiPartInputFile file((folder.path() / "a.exr").c_str());
  REQUIRE(file.parts() == 2);
  CHECK(file.header(0).name() == "level");
  CHECK(file.header(0).compression() == Imf::NO_COMPRESSION);
  CHECK(file.header(1).name() == "labels");
  CHECK(file.header(1).compression() == Imf::ZIP_COMPRESSION);

  const auto parts = value_of(read_exr_parts(folder.path() / "a.exr"));
  REQUIRE(parts.size() == 2);
  CHECK(parts[0].half_channels == std::vector<std::string>{"Y"});
  std::set<std::string> labels;
  for (const ImagePlane* plane : labels_of_exr()) labels.insert(plane->name);
  REQUIRE(labels.contains("clean_db"));
  CHECK(parts[1].half_channels == std::vector<std::string>(labels.begin(), labels.end()));
  CHECK(parts[0].other_channels.empty());
  CHECK(parts[1].other_channels.empty());
  CHECK(parts[1].width == kColumns);
  CHECK(parts[1].height == kRows);
}

// Protects every pixel's place and value, -99 dB and NaN included.
TEST_CASE("EXR pixels read back") {
  const sample::TemporaryFolder folder;
  const LabelledImage image = sample::image(kRows, kColumns, 3);
  sample::write(folder.path() / "a.exr", encode(image));
  Imf::MultiPartInputFile file((folder.path() / "a.exr").c_str());
  const auto compare = [](const std::vector<half>& got, const std::vector<float>& expected) {
    for (std::size_t i = 0; i < got.size(); ++i) {
      if (std::isnan(expected[i])) {
        CHECK(got[i].isNan());
      } else {
        CHECK(static_cast<float>(got[i]) == Approx(expected[i]).epsilon(1e-3));
      }
    }
  };
  compare(read_channel(file, 0, "Y"), image.level_db);
  for (const ImagePlane* plane : labels_of_exr()) {
    INFO(plane->name);
    compare(read_channel(file, 1, plane->name), floats_of(image, *plane));
  }
  CHECK(read_channel(file, 0, "Y")[0] == -99);
  CHECK(read_channel(file, 1, "elevation_rad")[0].isNan());
}

// Protects readers from infinities: what a half cannot hold stops at its largest value.
TEST_CASE("EXR levels do not overflow to infinity") {
  const sample::TemporaryFolder folder;
  LabelledImage image = sample::image(kRows, kColumns, 0);
  image.level_db[1] = 1e6f;
  image.level_db[2] = -std::numeric_limits<float>::infinity();
  sample::write(folder.path() / "a.exr", encode(image));
  Imf::MultiPartInputFile file((folder.path() / "a.exr").c_str());
  const auto level = read_channel(file, 0, "Y");
  CHECK(level[1] == 65504);
  CHECK(level[2] == -65504);
}

// Protects every value that a half can have, what lies between two of them and beside that middle.
TEST_CASE("halves are the nearest ones, half to even") {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  int wrong = 0;
  for (unsigned bits = 0; bits < 65536; ++bits) {
    half exact;
    exact.setBits(static_cast<std::uint16_t>(bits));
    half next;
    next.setBits(static_cast<std::uint16_t>(bits + 1));
    const float value = exact;
    if (exact.isFinite()) wrong += to_half(value) != bits;
    const float middle = (value + static_cast<float>(next)) / 2;
    for (const float x :
         {value, middle, std::nextafter(middle, kInfinity), std::nextafter(middle, -kInfinity)}) {
      wrong += to_half(x) != expected_half(x);
    }
  }
  CHECK(wrong == 0);
}

// Protects the rest of the floats: a million of all bit patterns, NaN and beyond the range
// included.
TEST_CASE("random floats become the halves that Imath makes of them") {
  std::mt19937 random(1);
  int wrong = 0;
  for (int i = 0; i < 1000000; ++i) {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    wrong += to_half(value) != expected_half(value);
  }
  CHECK(wrong == 0);
}

// Protects chunks: the last one has fewer rows than the others; noise does not compress and is
// stored as it is; constants and noise stand side by side.
TEST_CASE("EXR pixels read back from several chunks") {
  constexpr int kTall = 37, kWide = 129;
  LabelledImage image = sample::image(kTall, kWide, 1);
  std::mt19937 random(2);
  const auto fill = [&](std::vector<float>& layer) {
    for (float& x : layer) {
      half h;
      h.setBits(static_cast<std::uint16_t>(random()));
      x = h.isFinite() ? static_cast<float>(h) : -99;
    }
  };
  fill(image.level_db);
  fill(image.clean_db);
  SECTION("all noise") {
    for (const ImagePlane* plane : labels_of_exr()) fill(floats_of(image, *plane));
  }
  SECTION("noise and constants") {
    image.elevation_rad.assign(kTall * kWide, std::numeric_limits<float>::quiet_NaN());
    image.instance_fraction.assign(kTall * kWide, 1);
  }
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / "a.exr", encode(image));
  Imf::MultiPartInputFile file((folder.path() / "a.exr").c_str());
  const auto wrong = [&](int part, const char* name, const std::vector<float>& layer) {
    const auto got = read_channel(file, part, name);
    REQUIRE(got.size() == layer.size());
    int count = 0;
    for (std::size_t i = 0; i < got.size(); ++i) count += got[i].bits() != expected_half(layer[i]);
    return count;
  };
  CHECK(wrong(0, "Y", image.level_db) == 0);
  for (const ImagePlane* plane : labels_of_exr()) {
    INFO(plane->name);
    CHECK(wrong(1, plane->name, floats_of(image, *plane)) == 0);
  }
}

// Protects the units and scales in the headers, and that nothing of the machine or the clock is
// beside them.
// Protects the file of surfaces, read by OpenEXR: one part of floats, all bits kept, in more than
// one chunk.
TEST_CASE("planes of surfaces are floats in a file of their own") {
  const sample::TemporaryFolder folder;
  OutputSelection output;
  output.surfaces = true;
  const LabelledImage image = sample::image(40, 7, 2, output);
  const auto bytes = value_of(encode_group_exr(image, kSurfacePlanes, kAttributes));
  const auto path = folder.path() / "s.exr";
  sample::write(path, bytes);
  const auto parts = value_of(read_exr_parts(path));
  REQUIRE(parts.size() == 1);
  CHECK(parts[0].float_channels == exr_channels(kSurfacePlanes));
  CHECK(parts[0].float_channels.size() == 12);
  CHECK(parts[0].half_channels.empty());
  const auto planes = value_of(read_group_exr(path, kSurfacePlanes, 40, 7));
  for (const ImagePlane& plane : kImagePlanes) {
    if (plane.group() != kSurfacePlanes) continue;
    INFO(plane.name);
    const std::vector<float>& written = floats_of(image, plane);
    const std::vector<float>& read = planes.at(plane.name);
    REQUIRE(read.size() == written.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      CHECK(std::bit_cast<std::uint32_t>(read[i]) == std::bit_cast<std::uint32_t>(written[i]));
    }
  }
  CHECK_FALSE(read_group_exr(path, kSurfacePlanes, 40, 8));
  CHECK_FALSE(read_exr_halves(path, 40, 7));
  sample::write(path, bytes.substr(0, bytes.size() / 2));
  CHECK_FALSE(read_group_exr(path, kSurfacePlanes, 40, 7));
}

// Protects front views: all float planes, bit for bit, and no other size.
TEST_CASE("a front view comes back from EXR as it went") {
  const sample::TemporaryFolder folder;
  SequenceInfo info = sample::sequence_info(0);
  info.output.front = true;
  const FrontView view = *sample::ping_result(info, 1).front;
  const auto bytes = value_of(encode_front_exr(view, kAttributes));
  const auto path = folder.path() / "f.exr";
  sample::write(path, bytes);
  const auto parts = value_of(read_exr_parts(path));
  REQUIRE(parts.size() == 1);
  CHECK(parts[0].float_channels ==
        std::vector<std::string>{"backscatter_db", "normal_x", "normal_y", "normal_z", "range_m"});
  CHECK(parts[0].float_channels == front_exr_channels());
  const auto planes = value_of(read_front_exr(path, view.rows, view.columns));
  for (const FrontPlane& plane : kFrontPlanes) {
    if (!is_float_plane(plane)) continue;
    INFO(plane.name);
    const auto& written = view.*std::get<std::vector<float> FrontView::*>(plane.values);
    const std::vector<float>& read = planes.at(plane.name);
    REQUIRE(read.size() == written.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      CHECK(std::bit_cast<std::uint32_t>(read[i]) == std::bit_cast<std::uint32_t>(written[i]));
    }
  }
  CHECK_FALSE(read_front_exr(path, view.rows + 1, view.columns));
  CHECK_FALSE(read_group_exr(path, kSurfacePlanes, view.rows, view.columns));
}

TEST_CASE("EXR headers hold units and scales and no date or host") {
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / "a.exr", encode(sample::image(kRows, kColumns, 0)));
  Imf::MultiPartInputFile file((folder.path() / "a.exr").c_str());
  for (int part = 0; part < 2; ++part) {
    const Imf::Header& header = file.header(part);
    CHECK(header.typedAttribute<Imf::DoubleAttribute>("metres_per_pixel").value() == 1.0 / 3);
    CHECK(header.typedAttribute<Imf::StringAttribute>("axes").value() == "rows: samples");
    CHECK(contains(header.typedAttribute<Imf::StringAttribute>("units").value(), "dB re 1 uPa"));
    CHECK_FALSE(Imf::hasCapDate(header));
    CHECK_FALSE(Imf::hasOwner(header));
    std::vector<std::string> names;
    for (auto a = header.begin(); a != header.end(); ++a) names.emplace_back(a.name());
    const std::vector<std::string> expected = {"axes",
                                               "channels",
                                               "chunkCount",
                                               "compression",
                                               "dataWindow",
                                               "displayWindow",
                                               "lineOrder",
                                               "metres_per_pixel",
                                               "name",
                                               "no_energy",
                                               "pixelAspectRatio",
                                               "screenWindowCenter",
                                               "screenWindowWidth",
                                               "type",
                                               "units"};
    CHECK(names == expected);
  }
}

// Protects the promise of equal bytes for equal pictures, and that a NaN's bits do not matter.
TEST_CASE("EXR bytes depend on the picture alone") {
  LabelledImage image = sample::image(kRows, kColumns, 0);
  const std::string first = encode(image);
  image.elevation_rad[0] = -image.elevation_rad[0];  // NaN with the other sign
  REQUIRE(std::isnan(image.elevation_rad[0]));
  CHECK(encode(image) == first);
  image.instance_fraction[1] += 0.25f;
  CHECK(encode(image) != first);
}

// Protects verify: what ends before its pixels is no picture.
TEST_CASE("an EXR file that is cut short in its headers is damage") {
  const sample::TemporaryFolder folder;
  const std::string bytes = encode(sample::image(kRows, kColumns, 0));
  for (const std::size_t size : {std::size_t{0}, std::size_t{100}, bytes.size() / 3}) {
    sample::write(folder.path() / "a.exr", bytes.substr(0, size));
    check_fails(read_exr_parts(folder.path() / "a.exr"), ErrorKind::damage);
  }
}
