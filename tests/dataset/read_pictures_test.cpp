// Pictures and series read back from files of a ping and from packed arrays.
#include "dataset/read_pictures.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <string_view>
#include <variant>

#include "catch.h"
#include "dataset/layout.h"
#include "dataset/sample.h"
#include "dataset/verify.h"
#include "dataset/write_ping.h"
#include "formats/bytes.h"
#include "formats/npy.h"
#include "results.h"

using namespace ensonify;
namespace fs = std::filesystem;

namespace {

const std::string kSequenceFolder = "sequences/000000/";

PlaneNames all_planes() {
  PlaneNames names;
  for (const ImagePlane& plane : kImagePlanes) names.insert(plane.name);
  return names;
}

enum class Store { files, arrays, series_as_exr };

SequenceInfo info_of(Store store) {
  SequenceInfo info = sample::sequence_info(0);
  info.output.timeseries_exr = store == Store::series_as_exr;
  info.output.timeseries = store != Store::series_as_exr;
  info.output.packed = store == Store::arrays;
  for (const ImagePlane& plane : kImagePlanes) {
    if (plane.wanted != nullptr) info.output.*plane.wanted = true;
  }
  info.first_ping = 4;
  info.last_ping = 4 + sample::kPings;
  return info;
}

struct Made {
  explicit Made(
      Store store, const std::function<void(SequenceInfo&)>& change = [](SequenceInfo&) {}) {
    const fs::path& dir = folder.path();
    WorkIdentity identity = sample::identity();
    DatasetInfo all = sample::dataset_info(1);
    all.first = info_of(store);
    change(all.first);
    identity.first_ping = all.first.first_ping;
    identity.last_ping = all.first.last_ping;
    all.identity = identity;
    REQUIRE(open_work(dir, identity, 1, false).ok());
    sample::write_pings(dir, all.first);
    require_ok(sample::finish(dir, all.first));
    require_ok(finish_dataset(dir, all));
    dataset = value_of(open_dataset(dir));
    sequence = value_of(read_sequence(dataset, dataset.sequences.at(0)));
  }

  StoredPixels picture(ImageView view, std::uint32_t ping, const PlaneNames& planes) const {
    return value_of(read_picture(dataset, sequence, view, ping, planes));
  }
  fs::path file(const std::string& name) const { return folder.path() / (kSequenceFolder + name); }

  sample::TemporaryFolder folder;
  StoredDataset dataset;
  StoredSequence sequence;
};

// What a half holds of a value.
std::vector<float> rounded(const std::vector<float>& values) {
  std::vector<std::uint16_t> halves(values.size());
  to_halves(values, halves);
  std::vector<float> result(values.size());
  from_halves(halves, result);
  return result;
}

// NaN equals NaN here.
bool same(const std::vector<float>& a, const std::vector<float>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i])))) return false;
  }
  return true;
}

// Planes of surfaces are stored as they are.
bool reads_back(const ImagePlane& plane, const std::vector<float>& read,
                const std::vector<float>& written) {
  return same(read, has_own_file(plane) ? written : rounded(written));
}
template <class Id>
bool reads_back(const ImagePlane&, const std::vector<Id>& read, const std::vector<Id>& written) {
  return read == written;
}

void check_io(const Made& made, const std::string& name) {
  const auto pixels = read_picture(made.dataset, made.sequence, ImageView::polar, 5, all_planes());
  const auto series = read_series(made.dataset, made.sequence, 5);
  REQUIRE((!pixels.ok() || !series.ok()));
  const Error error = pixels.ok() ? series.error() : pixels.error();
  INFO(error.message);
  CHECK(error.kind == ErrorKind::io);
  CHECK(contains(error.message, name));
}

}  // namespace

// Protects the bits of every kind of half: all of them, there and back.
TEST_CASE("halves become floats exactly", "[serial]") {
  std::vector<std::uint16_t> halves(65536), again(65536);
  std::vector<float> values(65536);
  for (std::size_t i = 0; i < halves.size(); ++i) halves[i] = static_cast<std::uint16_t>(i);
  from_halves(halves, values);
  CHECK(values[0x3c00] == 1.0f);
  CHECK(values[0xc000] == -2.0f);
  CHECK(values[0x0001] == std::ldexp(1.0f, -24));
  CHECK(values[0x03ff] == 1023 * std::ldexp(1.0f, -24));
  CHECK(values[0x0400] == std::ldexp(1.0f, -14));
  CHECK(values[0x7bff] == 65504.0f);
  CHECK(std::isinf(values[0xfc00]));
  CHECK(std::isnan(values[0x7fff]));
  CHECK(std::signbit(values[0x8000]));
  to_halves(values, again);
  for (std::size_t i = 0; i < halves.size(); ++i) {
    const bool special = (i & 0x7c00) == 0x7c00;  // infinities are stored as the largest number
    if (!special && again[i] != halves[i]) FAIL("half " << i << " comes back as " << again[i]);
  }
}

// Protects every channel, both views, and that a ping is found by its number, not by its place.
TEST_CASE("pictures are read as they were written", "[serial]") {
  const Store store = GENERATE(Store::files, Store::arrays);
  const Made made(store);
  const SequenceInfo info = info_of(store);
  for (std::uint32_t ping = info.first_ping; ping < info.last_ping; ++ping) {
    const PingResult written = sample::ping_result(info, ping);
    for (const ImageView view : {ImageView::polar, ImageView::cartesian}) {
      const bool polar = view == ImageView::polar;
      const LabelledImage& image = polar ? *written.polar : *written.cartesian;
      const StoredPixels pixels = made.picture(view, ping, all_planes());
      CHECK(pixels.rows == (polar ? 9 : 7));
      CHECK(pixels.columns == (polar ? 6 : 8));
      for (const ImagePlane& plane : kImagePlanes) {
        INFO(plane.name);
        std::visit(
            [&](auto values) {
              CHECK((pixels.*values).empty() != sample::has_plane(info.output, plane));
              CHECK(reads_back(plane, pixels.*values, image.*values));
            },
            plane.values);
      }
    }
  }
}

TEST_CASE("series are read as they were written", "[serial]") {
  const Store store = GENERATE(Store::files, Store::arrays, Store::series_as_exr);
  const Made made(store);
  CHECK(has_series(made.sequence));
  for (std::uint32_t ping = 4; ping < 7; ++ping) {
    const auto series = read_series(made.dataset, made.sequence, ping);
    REQUIRE(series.ok());
    CHECK(Series(series->begin(), series->end()) ==
          sample::ping_result(info_of(store), ping).series);
  }
}

// Protects Cartesian planes that nobody stored: each is the polar one that the map names, with the
// bits that its own file would have, and blank outside. Ids are always files of their own.
TEST_CASE("Cartesian float planes come from the polar image through the map", "[serial]") {
  Store store = Store::files;
  bool with_polar = true;
  SECTION("files") {}
  SECTION("arrays") { store = Store::arrays; }
  SECTION("no polar image") { with_polar = false; }
  const Made made(store, [&](SequenceInfo& info) {
    info.output.cartesian_exr = false;
    info.output.polar = with_polar;
  });
  const PingResult written = sample::ping_result(info_of(store), 5);
  const std::vector<std::int32_t> map = sample::cartesian_map(info_of(store));
  const StoredPixels pixels = made.picture(ImageView::cartesian, 5, all_planes());
  CHECK(pixels.instance == written.cartesian->instance);
  CHECK(pixels.shadow == written.cartesian->shadow);
  for (const ImagePlane& plane : kImagePlanes) {
    if (!is_float_plane(plane)) continue;
    INFO(plane.name);
    CHECK_FALSE(made.sequence.has(plane_row(ImageView::cartesian, plane.name)));
    const auto values = std::get<std::vector<float> ImagePlanes::*>(plane.values);
    std::vector<float> expected;
    for (const std::int32_t from : map) {
      if (!with_polar) break;
      expected.push_back(from < 0 ? blank_value<float>(plane.blank)
                                  : (*written.polar.*values)[from]);
    }
    CHECK(reads_back(plane, pixels.*values, expected));
    CHECK(can_read(made.sequence, plane_row(ImageView::cartesian, plane.name)) == with_polar);
    if (!with_polar || has_own_file(plane)) continue;
    std::vector<std::uint16_t> halves(expected.size());
    to_halves(expected, halves);
    CellReader reader(made.dataset, made.sequence, 5);
    const auto bytes = value_of(reader.read(plane_row(ImageView::cartesian, plane.name)));
    CHECK(values_in<std::uint16_t>(bytes) == halves);
  }
}

// Protects front views of files and of arrays: every plane as it was made, and no other size.
TEST_CASE("front views come back as they were made") {
  const Store store = GENERATE(Store::files, Store::arrays);
  const Made made(store, [](SequenceInfo& info) { info.output.front = true; });
  SequenceInfo info = info_of(store);
  info.output.front = true;
  for (const std::uint32_t ping : {4u, 6u}) {
    const FrontView written = *sample::ping_result(info, ping).front;
    CellReader reader(made.dataset, made.sequence, ping);
    for (const FrontPlane& plane : kFrontPlanes) {
      INFO(plane.name);
      const CatalogueRow* row = find_array(std::string("front_") + plane.name + ".npy");
      REQUIRE(row != nullptr);
      REQUIRE(can_read(made.sequence, *row));
      const auto bytes = value_of(reader.read(*row));
      with_plane(written, plane, [&](const auto& values) {
        REQUIRE(bytes.size() == values.size() * sizeof values[0]);
        CHECK(std::memcmp(bytes.data(), values.data(), bytes.size()) == 0);
      });
    }
  }
  const auto report = value_of(verify_dataset(made.folder.path(), Workers(1)));
  CHECK(report.faults == std::vector<std::string>{});
  CHECK(made.sequence.sizes().elevations == 3);
  CHECK(made.sequence.sizes().azimuths == 6);
  const auto elevations =
      value_of(read_npy(made.file("front_elevation_rad.npy"), kNpyFloat64, {3}));
  CHECK(values_in<double>(elevations.data())[0] == Approx(-0.1));
}

// Protects memory from a map that names pixels beyond the polar image.
TEST_CASE("a map that does not fit the polar image is an error", "[serial]") {
  const Made made(Store::files, [](SequenceInfo& info) { info.output.cartesian_exr = false; });
  const fs::path file = made.file("cartesian_map.npy");
  std::string bytes = sample::read(file);
  SECTION("missing") { fs::remove(file); }
  SECTION("cut short") { sample::write(file, bytes.substr(0, bytes.size() - 4)); }
  SECTION("a pixel too far") {
    const std::int32_t beyond = sample::kSamples * sample::kBeams;
    std::memcpy(bytes.data() + bytes.size() - 4, &beyond, 4);
    sample::write(file, bytes);
  }
  check_fails(read_picture(made.dataset, made.sequence, ImageView::cartesian, 5, {"clean_db"}),
              ErrorKind::io, {"cartesian_map.npy"});
}

// Protects readers that want one channel from paying for others, or for what is not there.
TEST_CASE("what was not asked for or is not there stays empty", "[serial]") {
  Made made(GENERATE(Store::files, Store::arrays));
  CHECK(stored_planes(made.sequence, ImageView::polar) == all_planes());
  const StoredPixels pixels = made.picture(ImageView::polar, 5, {"semantic"});
  CHECK(pixels.semantic.size() == 54);
  for (const ImagePlane& plane : kImagePlanes) {
    INFO(plane.name);
    const bool empty = with_plane(pixels, plane, [](const auto& v) { return v.empty(); });
    CHECK(empty == (std::string_view(plane.name) != "semantic"));
  }

  made.sequence.arrays.clear();
  made.sequence.each_ping.clear();
  const StoredPixels none = made.picture(ImageView::polar, 5, all_planes());
  CHECK((none.level_db.empty() && none.instance.empty() && none.shadow.empty()));
  CHECK(stored_planes(made.sequence, ImageView::cartesian).empty());
  CHECK_FALSE(has_series(made.sequence));
  CHECK(read_series(made.dataset, made.sequence, 5)->empty());
}

// Protects the reader's promise: whatever a file has become, it is told with its name.
TEST_CASE("damaged files of pictures are errors", "[serial]") {
  const auto [store, name] =
      GENERATE(table<Store, std::string>({{Store::files, "polar/000005.exr"},
                                          {Store::files, "polar/000005_instance.png"},
                                          {Store::files, "polar/000005_semantic.png"},
                                          {Store::files, "polar/000005_shadow.png"},
                                          {Store::files, "timeseries/000005.npy"},
                                          {Store::series_as_exr, "timeseries/000005.exr"},
                                          {Store::arrays, "polar_level_db.npy"},
                                          {Store::arrays, "polar_instance.npy"},
                                          {Store::arrays, "polar_semantic.npy"},
                                          {Store::arrays, "timeseries.npy"}}));
  const Made made(store);
  const fs::path file = made.file(name);
  INFO(name);
  SECTION("missing") {
    fs::remove(file);
    check_io(made, name);
  }
  SECTION("a link") {
    const fs::path outside = made.folder.path() / "outside";
    fs::rename(file, outside);
    fs::create_symlink(outside, file);
    check_io(made, name);
  }
  SECTION("empty") {
    sample::write(file, "");
    check_io(made, name);
  }
  SECTION("cut short") {
    // In the middle of ping 5, the second of three.
    fs::resize_file(file, fs::file_size(file) * (store == Store::arrays ? 45 : 60) / 100);
    check_io(made, name);
  }
  SECTION("something else") {
    sample::write(file, std::string(5000, 'x'));
    check_io(made, name);
  }
}

// Protects memory: a picture of another size than the sequence's is refused before it is read.
TEST_CASE("pictures of another size are errors", "[serial]") {
  const Store store = GENERATE(Store::files, Store::arrays);
  Made made(store);
  made.sequence.samples = 1'000'000;
  made.sequence.beams = 2000;
  for (const char* plane : {"level_db", "instance"}) {
    check_fails(read_picture(made.dataset, made.sequence, ImageView::polar, 5, {plane}),
                ErrorKind::io);
  }
  check_fails(read_series(made.dataset, made.sequence, 5), ErrorKind::io);
}
