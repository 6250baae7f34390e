// Arrays of all pings: what they hold, and that no kill leaves anything else.
#include "dataset/packed.h"

#include <fmt/format.h>

#include <cstring>
#include <filesystem>

#include "catch.h"
#include "dataset/catalogue.h"
#include "dataset/damage.h"
#include "dataset/layout.h"
#include "dataset/sample.h"
#include "dataset/verify.h"
#include "dataset/write_ping.h"
#include "formats/bytes.h"
#include "formats/bytes.h"
#include "results.h"

using namespace ensonify;
namespace fs = std::filesystem;

namespace {

constexpr std::uint32_t kSequences = 2;
const std::string kFolder = "sequences/000000/";

SequenceInfo packed_info(std::uint32_t sequence) {
  SequenceInfo info = sample::sequence_info(sequence);
  info.output.timeseries_exr = false;
  info.output.packed = true;
  info.output.layers = true;
  info.layers = {Layer::noise, Layer::target};
  info.target_instances = {2};
  return info;
}

PingResult packed_result(const SequenceInfo& info, std::uint32_t ping) {
  PingResult result = sample::ping_result(info, ping);
  for (const Layer layer : info.layers) {
    result.layers.push_back({layer, result.series});
    for (auto& p : result.layers.back().pressure_pa) p *= layer == Layer::noise ? 0.25f : 0.75f;
  }
  return result;
}

DatasetInfo dataset() {
  DatasetInfo info = sample::dataset_info(kSequences);
  info.first = packed_info(0);
  return info;
}

void write_pings(const fs::path& dir, const SequenceInfo& info, int threads = 2) {
  for (std::uint32_t ping = info.first_ping; ping < info.last_ping; ++ping) {
    if (ping_is_finished(dir, info.sequence, ping, info)) continue;
    require_ok(write_ping(dir, info, packed_result(info, ping), Workers(threads)));
  }
}

// As the program does, whatever state the folder is in.
void go_on(const fs::path& dir, int threads = 2) {
  const auto state = value_of(open_work(dir, sample::identity(), kSequences, false));
  if (state == FolderState::complete) return;
  for (std::uint32_t s = 0; s < kSequences; ++s) {
    const SequenceInfo info = packed_info(s);
    if (!sequence_is_finished(dir, s)) write_pings(dir, info, threads);
    if (!sequence_is_finished(dir, s)) require_ok(sample::finish(dir, info));
  }
  require_ok(finish_dataset(dir, dataset()));
}

std::map<std::string, std::string> whole() {
  const sample::TemporaryFolder folder;
  go_on(folder.path());
  return sample::contents(folder.path());
}

// The data of an array's file behind its header, and its shape.
std::pair<NpyHeader, std::string> array_of(const fs::path& dir, const std::string& name) {
  const std::string bytes = sample::read(dir / (kFolder + name));
  const auto header = value_of(parse_npy_header(bytes));
  return {header, bytes.substr(header.data_offset)};
}

template <class Values>
std::string raw(const Values& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])};
}

template <class Id>
std::string stored(const std::vector<Id>& ids) {
  return raw(ids);
}
std::string stored(const std::vector<float>& values) {
  std::vector<std::uint16_t> result(values.size());
  to_halves(values, result);
  return raw(result);
}

}  // namespace

// Protects every array: its type, its shape, and each ping's values in its place.
TEST_CASE("arrays hold what the pings hold, one behind the other") {
  const sample::TemporaryFolder folder;
  go_on(folder.path());
  const SequenceInfo info = packed_info(0);
  std::map<std::string, std::string> expected;
  for (std::uint32_t ping = 0; ping < sample::kPings; ++ping) {
    const PingResult r = packed_result(info, ping);
    expected["timeseries.npy"] += raw(r.series);
    expected["layers_noise.npy"] += raw(r.layers[0].pressure_pa);
    expected["layers_target.npy"] += raw(r.layers[1].pressure_pa);
    expected["polar_grey.npy"] += raw(r.polar_grey->pixels);
    expected["cartesian_grey.npy"] += raw(r.cartesian_grey->pixels);
    using View = std::pair<std::string, const LabelledImage*>;
    for (const auto& [v, image] : {View("polar_", &*r.polar), View("cartesian_", &*r.cartesian)}) {
      for (const ImagePlane& plane : kImagePlanes) {
        if (!sample::has_plane(info.output, plane)) continue;
        expected[v + plane.name + ".npy"] +=
            with_plane(*image, plane, [](const auto& values) { return stored(values); });
      }
    }
  }
  CHECK(arrays_of(selection_of(info)).size() == expected.size());
  for (const auto& [name, bytes] : expected) {
    INFO(name);
    CHECK(array_of(folder.path(), name).second == bytes);
  }
  CHECK(array_of(folder.path(), "timeseries.npy").first.shape == NpyShape{3, 6, 9});
  CHECK(array_of(folder.path(), "polar_instance.npy").first.shape == NpyShape{3, 9, 6});
  CHECK(array_of(folder.path(), "polar_instance.npy").first.descr == "'<u2'");
  CHECK(array_of(folder.path(), "cartesian_clean_db.npy").first.shape == NpyShape{3, 7, 8});
  CHECK(array_of(folder.path(), "cartesian_clean_db.npy").first.descr == "'<f2'");
  CHECK(array_of(folder.path(), "polar_grey.npy").first.descr == "'|u1'");
  CHECK(damage::faults(folder.path()) == std::vector<std::string>{});
}

// Protects few files: no picture and no series of a ping, no piece; scatterers and points differ in
// length and stay one a ping.
TEST_CASE("a packed sequence has no files of pings but its lists") {
  for (const auto& [name, bytes] : whole()) {
    const auto file =
        layout::parse_ping_file(name.starts_with(kFolder) ? name.substr(kFolder.size()) : "");
    if (file) {
      CHECK((file->name_template == layout::kScatterers || file->name_template == layout::kPoints));
    }
    CHECK_FALSE(contains(name, "pieces"));
  }
}

TEST_CASE("packed bytes do not depend on the number of threads") {
  const sample::TemporaryFolder folder;
  go_on(folder.path(), 1);
  CHECK(sample::contents(folder.path()) == whole());
}

// Protects going on after a kill at any of the steps of making and finishing a sequence.
TEST_CASE("packed work that was cut off anywhere ends in the same bytes") {
  const auto expected = whole();
  const sample::TemporaryFolder folder;
  const fs::path& dir = folder.path();
  sample::open(dir, kSequences);
  const SequenceInfo info = packed_info(0);
  write_pings(dir, info);
  const auto pieces = sample::contents(dir);
  const auto put_back = [&](auto wanted) {
    for (const auto& [name, bytes] : pieces) {
      if (wanted(name)) sample::write(dir / name, bytes);
    }
  };
  const auto is_piece = [](const std::string& name) {
    return name.find("/pieces/") != std::string::npos;
  };
  REQUIRE(fs::exists(dir / (kFolder + "pieces/000002.bin")));
  CHECK_FALSE(fs::exists(dir / (kFolder + "timeseries.npy")));

  SECTION("with all pings, nothing finished") {}
  SECTION("a piece missing") { fs::remove(dir / (kFolder + "pieces/000001.bin")); }
  SECTION("a piece cut short") { fs::resize_file(dir / (kFolder + "pieces/000001.bin"), 100); }
  SECTION("some arrays written, one of them by another's hand cut short") {
    sample::write(dir / (kFolder + "timeseries.npy"), expected.at(kFolder + "timeseries.npy"));
    sample::write(dir / (kFolder + "polar_grey.npy"), "part");
    sample::write(dir / ".work/tmp/123-abc", "half an array");
  }
  SECTION("sequence.json written, the pieces still there") {
    require_ok(sample::finish(dir, info));
    CHECK_FALSE(fs::exists(dir / (kFolder + "pieces")));
    put_back(is_piece);
  }
  SECTION("some of the pieces removed") {
    require_ok(sample::finish(dir, info));
    put_back([&](const std::string& name) { return is_piece(name) && name.ends_with("2.bin"); });
  }
  SECTION("an array lost after sequence.json, the pieces gone") {
    require_ok(sample::finish(dir, info));
    fs::remove(dir / (kFolder + "polar_level_db.npy"));
  }
  SECTION("sealed, and a second copy of the work left a piece behind") {
    go_on(dir);
    put_back(is_piece);
    CHECK_FALSE(damage::faults(dir).empty());
  }
  go_on(dir);
  CHECK(sample::contents(dir) == expected);
  CHECK(damage::faults(dir) == std::vector<std::string>{});
}

// Protects finishing: it says what is missing and leaves no array.
TEST_CASE("a packed sequence without a piece is not finished") {
  const sample::TemporaryFolder folder;
  sample::open(folder.path(), kSequences);
  const SequenceInfo info = packed_info(0);
  write_pings(folder.path(), info);
  fs::remove(folder.path() / (kFolder + "pieces/000001.bin"));
  check_fails(sample::finish(folder.path(), info), {"ping 1"});
  CHECK_FALSE(fs::exists(folder.path() / (kFolder + "timeseries.npy")));
}

// Protects --overwrite: pieces and arrays of work that was cut off are ours, and nobody else's file
// is.
TEST_CASE("overwrite removes pieces and arrays and no stranger's file") {
  const sample::TemporaryFolder folder;
  const fs::path& dir = folder.path();
  sample::open(dir, kSequences);
  write_pings(dir, packed_info(0));
  sample::write(dir / (kFolder + "timeseries.npy"), "an array of a finishing that was cut off");
  WorkIdentity other = sample::identity();
  other.seed = 8;
  SECTION("ours alone") {
    sample::write(dir / (kFolder + "notes.txt"), "kept");
    REQUIRE(open_work(dir, other, kSequences, true).ok());
    CHECK_FALSE(fs::exists(dir / (kFolder + "pieces")));
    CHECK_FALSE(fs::exists(dir / (kFolder + "timeseries.npy")));
    CHECK(fs::exists(dir / (kFolder + "notes.txt")));
  }
  SECTION("a stranger's piece") {
    sample::write(dir / (kFolder + "pieces/000077.bin"), "not of this range");
    check_fails(open_work(dir, other, kSequences, true), {"pieces/000077.bin"});
    CHECK(fs::exists(dir / (kFolder + "pieces/000000.bin")));
  }
}

// Protects the list of pictures: an array is no picture file, so it is named apart.
TEST_CASE("coco names the array and the place in it") {
  const auto files = whole();
  const std::string& coco = files.at("coco.json");
  CHECK_FALSE(contains(coco, "file_name"));
  CHECK(contains(coco, R"("array":"sequences/000001/cartesian_grey.npy","index":2)"));
  CHECK(contains(files.at(kFolder + "sequence.json"), R"("pack": "sequence")"));
  SequenceInfo info = packed_info(0);
  CHECK(picture_row(ImageView::polar, selection_of(info))->array == "polar_grey.npy");
  info.output.png = false;
  CHECK(picture_row(ImageView::cartesian, selection_of(info))->array == "cartesian_level_db.npy");
  info.output.cartesian_exr = false;
  CHECK(picture_row(ImageView::cartesian, selection_of(info)) == nullptr);
}

// Protects verify from arrays of a wrong form whose hashes are right: each array's own size and
// type come from the sequence, not from the file.
TEST_CASE("an array is known by its name") {
  for (const CatalogueRow* row : arrays_of(selection_of(packed_info(0)))) {
    CHECK(find_array(row->array) == row);
    CHECK(layout::is_layout_name(kFolder + row->array));
  }
  CHECK(find_array("polar_colour.npy") == nullptr);
  CHECK_FALSE(layout::is_layout_name(kFolder + "polar_colour.npy"));
  CHECK(layout::is_layout_name(kFolder + "pieces/000003.bin"));
}
