#include "dataset/finish.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "catch.h"
#include "core/units.h"
#include "dataset/sample.h"
#include "dataset/verify.h"
#include "dataset/write_ping.h"
#include "formats/npy.h"
#include "formats/sha256.h"
#include "results.h"

using namespace ensonify;
namespace fs = std::filesystem;
using SortedJson = nlohmann::json;

namespace {

SortedJson json_in(const fs::path& file) { return SortedJson::parse(sample::read(file)); }

template <class T>
std::vector<T> array_in(const fs::path& file) {
  const std::string bytes = sample::read(file);
  const std::size_t offset = parse_npy_header(bytes)->data_offset;
  std::vector<T> values((bytes.size() - offset) / sizeof(T));
  std::memcpy(values.data(), bytes.data() + offset, values.size() * sizeof(T));
  return values;
}

// A data set of this one sequence.
void make_of(const fs::path& dir, const SequenceInfo& info) {
  sample::open(dir, 1);
  sample::write_pings(dir, info);
  REQUIRE(sample::finish(dir, info).ok());
  DatasetInfo dataset = sample::dataset_info(1);
  dataset.first = info;
  REQUIRE(finish_dataset(dir, dataset).ok());
}

// Each member of `expected` is the same in `json`, which may have more.
void check_members(const SortedJson& json, const SortedJson& expected) {
  for (const auto& [key, value] : expected.items()) {
    INFO(key);
    CHECK(json.at(key) == value);
  }
}

}  // namespace

// Protects the sequence's arrays: axes in radians and metres, first returns by ping with NaN.
TEST_CASE("a finished sequence has its axes and first returns") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  const fs::path dir = folder.path() / "sequences/000000";
  const auto info = sample::sequence_info(0);
  CHECK(array_in<double>(dir / "azimuth_rad.npy") == beam_azimuths_rad(info.sonar));
  const auto ranges = array_in<double>(dir / "range_m.npy");
  REQUIRE(ranges.size() == sample::kSamples);
  CHECK(ranges[0] == 0);
  CHECK(ranges[4] == Approx(1500 * 4 / (2 * 29.9e3)).epsilon(1e-14));
  const auto first = array_in<float>(dir / "first_return_m.npy");
  REQUIRE(first.size() == sample::kPings * sample::kBeams);
  CHECK(first[sample::kBeams] == 0.1f);
  CHECK(first[sample::kBeams + 1] == 1.1f);
  CHECK(std::isnan(first[2]));
}

// Protects the tables' columns and digits: 1/3 must come back as the same double.
TEST_CASE("a finished sequence has its poses and objects") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  const fs::path dir = folder.path() / "sequences/000000";
  const std::string poses = sample::read(dir / "poses.csv");
  CHECK(
      poses.starts_with("ping,time_s,x,y,z,qw,qx,qy,qz\n"
                        "0,0,0.3333333333333333,2,-3,0.7071067811865476,0,0,0.7071067811865475\n"
                        "1,0.1,1.3333333333333333,2,-3,"));
  CHECK(std::count(poses.begin(), poses.end(), '\n') == sample::kPings + 1);
  CHECK(sample::read(dir / "poses.tum")
            .starts_with("0 0.3333333333333333 2 -3 0 0 0.7071067811865475 0.7071067811865476\n"));
  const std::string objects = sample::read(dir / "objects.csv");
  CHECK(
      objects.starts_with("ping,instance,x,y,z,qw,qx,qy,qz\n0,1,0,0,0,1,0,0,0\n"
                          "0,2,4,0,0,1,0,0,0\n1,1,0,0,0,1,0,0,0\n1,2,4,0,0.5,1,0,0,0\n"));
}

// Protects 3-D labels: the box stands in the world where its object does, and in the sonar's frame
// where the sonar sees it. The sample's sonar is at (1/3, 2, -3) and looks along y.
TEST_CASE("a finished sequence has the boxes of its instances in both frames") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  std::istringstream boxes(sample::read(folder.path() / "sequences/000000/boxes.csv"));
  std::string line;
  std::getline(boxes, line);
  CHECK(line ==
        "ping,instance,size_x,size_y,size_z,x,y,z,qw,qx,qy,qz,"
        "sonar_x,sonar_y,sonar_z,sonar_qw,sonar_qx,sonar_qy,sonar_qz");
  const double root_half = std::sqrt(0.5);
  const double expected[] = {0, 1, 2,  4,        6, 1,         0, 0, 1,         0,
                             0, 0, -2, -2.0 / 3, 3, root_half, 0, 0, -root_half};
  std::getline(boxes, line);
  std::istringstream row(line);
  for (const double value : expected) {
    std::string column;
    REQUIRE(std::getline(row, column, ','));
    CHECK(std::stod(column) == Approx(value).margin(1e-12));
  }
  int rows = 1;
  while (std::getline(boxes, line)) ++rows;
  CHECK(rows == sample::kPings);
}

// Protects the manifest of a sequence: every file but itself, with true sizes and hashes.
TEST_CASE("sequence.json lists every file of the sequence") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  const fs::path dir = folder.path() / "sequences/000000";
  auto contents = sample::contents(dir);
  contents.erase("sequence.json");
  const SortedJson json = json_in(dir / "sequence.json");
  REQUIRE(json["files"].size() == contents.size());
  std::uint64_t bytes = 0;
  for (const SortedJson& entry : json["files"]) {
    const std::string& content = contents.at(entry["path"]);
    CHECK(entry["bytes"] == content.size());
    CHECK(entry["sha256"] == sha256_hex(content));
    bytes += content.size();
  }
  CHECK(json["bytes"] == bytes);
}

// Protects the top-level tables and the numbering of COCO's images and annotations.
TEST_CASE("a finished data set has its index, splits and boxes") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 2);
  CHECK(sample::read(folder.path() / "index.csv") ==
        "sequence,ping,time_s,split,stem\n0,0,0,train,000000/000000\n0,1,0.1,train,000000/000001\n"
        "0,2,0.2,train,000000/000002\n1,0,0,val,000001/000000\n1,1,0.1,val,000001/000001\n"
        "1,2,0.2,val,000001/000002\n");
  CHECK(sample::read(folder.path() / "splits/train.txt") ==
        "000000/000000\n000000/000001\n000000/000002\n");
  CHECK(sample::read(folder.path() / "splits/test.txt").empty());

  const SortedJson coco = json_in(folder.path() / "coco.json");
  REQUIRE(coco["images"].size() == 2 * 2 * sample::kPings);
  REQUIRE(coco["annotations"].size() == 3 * 2 * sample::kPings);
  CHECK(coco["categories"][1]["id"] == 2);
  CHECK(coco["categories"][1]["name"] == "cylinder");
  check_members(coco["images"][1], {{"id", 2},
                                    {"file_name", "sequences/000000/png/000000_cartesian.png"},
                                    {"width", 8},
                                    {"height", 7}});
  check_members(coco["annotations"][1], SortedJson::parse(R"({
      "image_id": 2, "category_id": 1, "bbox": [1, 0, 2, 3], "area": 6, "iscrowd": 0,
      "segmentation": {"size": [7, 8], "counts": "7340S1"}, "name": "wall", "truncated": null,
      "contrast_db": null, "occlusion": 0.25, "polygons": [[1, 0, 3, 0, 3, 3, 1, 3]],
      "amodal_area": 9, "amodal_bbox": [1, 0, 3, 3],
      "amodal_segmentation": {"size": [7, 8], "counts": "734000l0"}})"));
  check_members(coco["annotations"][0], {{"truncated", 0.125}, {"contrast_db", 6.02}});
  CHECK(coco["annotations"][2]["occlusion"].is_null());
  // What is seen nowhere stands apart, so that no reader meets an empty mask.
  REQUIRE(coco["hidden"].size() == 2 * sample::kPings);
  const SortedJson& hidden = coco["hidden"][1];
  check_members(hidden,
                {{"image_id", 3}, {"category_id", 1}, {"instance_id", 1}, {"occlusion", 1}});
  CHECK(hidden["amodal_segmentation"]["counts"] == "01e1");
  CHECK_FALSE(hidden.contains("segmentation"));
}

// Protects COCO where the grey pictures are off: it refers to files that are there.
TEST_CASE("coco.json refers to the EXR files where there are no PNG pictures") {
  const sample::TemporaryFolder folder;
  auto info = sample::sequence_info(0);
  info.output.png = false;
  make_of(folder.path(), info);
  CHECK(json_in(folder.path() / "coco.json")["images"][0]["file_name"] ==
        "sequences/000000/polar/000000.exr");
}

// Protects training from masks in place of images: what has no image has its masks' boxes by
// sequence, and no image in COCO's list.
TEST_CASE("masks without an image are annotated, but not in coco.json") {
  const sample::TemporaryFolder folder;
  auto info = sample::sequence_info(0);
  info.output.png = info.output.cartesian_exr = false;
  make_of(folder.path(), info);
  const std::string lines = sample::read(folder.path() / "sequences/000000/annotations.jsonl");
  const SortedJson line = SortedJson::parse(lines.substr(0, lines.find('\n')));
  REQUIRE(line["images"].size() == 2);
  CHECK(line["images"][1]["view"] == "cartesian");
  CHECK(line["images"][1]["annotations"].size() == 2);
  CHECK_FALSE(line["images"][1].contains("file"));
  const SortedJson coco = json_in(folder.path() / "coco.json");
  CHECK(coco["images"].size() == sample::kPings);
  CHECK(coco["annotations"].size() == sample::kPings);
  const auto report = value_of(verify_dataset(folder.path(), Workers(2)));
  CHECK(report.faults == std::vector<std::string>{});
}

// Protects the manifest: version, numerics, hashes of every other top-level file, and its own seal.
TEST_CASE("dataset.json lists the top level and is sealed") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 2);
  const std::string text = sample::read(folder.path() / "dataset.json");
  CHECK(sample::read(folder.path() / "dataset.sha256") == sha256_hex(text) + "  dataset.json\n");
  const SortedJson json = SortedJson::parse(text);
  CHECK(json["numerics"]["embree_isa"] == "AVX2");
  CHECK(json["splits"]["val"] == SortedJson({1}));
  CHECK(json["sequences"][1]["sha256"] ==
        sha256_hex(sample::read(folder.path() / "sequences/000001/sequence.json")));
  CHECK(json["sequences"][1]["seed"] == 18446744073709551615u);
  std::vector<std::string> listed;
  for (const SortedJson& entry : json["files"]) {
    listed.push_back(entry["path"]);
    CHECK(entry["sha256"] == sha256_hex(sample::read(folder.path() / listed.back())));
  }
  CHECK(listed == std::vector<std::string>{"README.md", "coco.json", "croissant.json", "index.csv",
                                           "scenario.yaml", "splits/test.txt", "splits/train.txt",
                                           "splits/val.txt", "work.json"});
  CHECK_FALSE(fs::exists(folder.path() / ".work"));
}

// Protects "no time stamp, host name or path of the machine in any compared file": two runs in two
// places, on two hosts, are byte for byte the same.
TEST_CASE("two data sets of the same work are equal") {
  const sample::TemporaryFolder one, two;
  sample::make_dataset(one.path(), 2);
  sample::make_dataset(two.path(), 2);
  auto info = sample::dataset_info(2);
  info.host = "elsewhere";
  info.wall_seconds = 99;
  REQUIRE(finish_dataset(two.path(), info).ok());
  CHECK(sample::contents(one.path()) == sample::contents(two.path()));
  for (const auto& [name, bytes] : sample::contents(two.path())) {
    INFO(name);
    CHECK_FALSE(contains(bytes, two.path().string()));
    CHECK_FALSE(contains(bytes, "elsewhere"));
  }
}

// Protects input files: under their hash, and only if they still are what was hashed.
TEST_CASE("assets are copied under their hash") {
  const sample::TemporaryFolder folder, source;
  sample::make_dataset(folder.path(), 1);
  sample::write(source.path() / "ship.obj", "mesh");
  auto info = sample::dataset_info(1);
  info.assets = {{sha256_hex("mesh"), ".obj", source.path() / "ship.obj"}};
  REQUIRE(finish_dataset(folder.path(), info).ok());
  const std::string name = "assets/" + sha256_hex("mesh") + ".obj";
  CHECK(sample::read(folder.path() / name) == "mesh");
  CHECK(contains(sample::read(folder.path() / "dataset.json"), name));

  sample::write(source.path() / "ship.obj", "another mesh");
  check_fails(finish_dataset(folder.path(), info), ErrorKind::usage);
  CHECK(sample::read(folder.path() / name) == "mesh");
}

// Protects against finishing what is not there, with a count that helps.
TEST_CASE("finishing needs every ping and every sequence") {
  const sample::TemporaryFolder folder;
  const auto info = sample::sequence_info(0);
  sample::open(folder.path(), 1);
  sample::write_pings(folder.path(), info);
  fs::remove(folder.path() / "sequences/000000/polar/000001.exr");
  check_fails(sample::finish(folder.path(), info), ErrorKind::usage, {"1 of 3 pings"});
  CHECK_FALSE(sequence_is_finished(folder.path(), 0));
  check_fails(finish_dataset(folder.path(), sample::dataset_info(1)), ErrorKind::usage);
  CHECK_FALSE(fs::exists(folder.path() / "dataset.json"));
}

// Protects "no file of a sequence is ever overwritten": a finished sequence is left alone, with its
// records still there (a second copy at work) and without, and so are its pings.
TEST_CASE("a finished sequence is left alone") {
  const sample::TemporaryFolder folder;
  const auto info = sample::sequence_info(0);
  sample::open(folder.path(), 1);
  sample::write_pings(folder.path(), info);
  REQUIRE(sample::finish(folder.path(), info).ok());
  const fs::path poses = folder.path() / "sequences/000000/poses.csv";
  const fs::file_time_type stamp{};
  fs::last_write_time(poses, stamp);
  REQUIRE(sample::finish(folder.path(), info).ok());
  CHECK(fs::last_write_time(poses) == stamp);

  fs::remove_all(folder.path() / ".work");
  REQUIRE(sample::finish(folder.path(), info).ok());
  CHECK(fs::last_write_time(poses) == stamp);
  CHECK(ping_is_finished(folder.path(), 0, sample::kPings - 1, info));
  CHECK_FALSE(ping_is_finished(folder.path(), 0, sample::kPings, info));
  auto other = sample::ping_result(info, 1);
  other.series[0] = 99;
  const auto before = sample::contents(folder.path());
  REQUIRE(write_ping(folder.path(), info, other, Workers(1)).ok());
  CHECK(sample::contents(folder.path()) == before);
}
