#include "dataset/verify.h"

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "catch.h"
#include "dataset/damage.h"
#include "dataset/sample.h"
#include "formats/exr.h"
#include "formats/sha256.h"
#include "results.h"

using namespace ensonify;
using damage::edit;
using damage::faults;
using damage::forge;
using damage::mentions;
using damage::reseal;
namespace fs = std::filesystem;

// Protects from false alarms, and that verify looks at every file: its count and bytes are those of
// the folder.
TEST_CASE("a whole data set has no faults") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 2);
  const auto report = value_of(verify_dataset(folder.path(), Workers(2)));
  CHECK(report.faults == std::vector<std::string>{});
  const auto contents = sample::contents(folder.path());
  std::uint64_t bytes = 0;
  for (const auto& [name, content] : contents) bytes += content.size();
  CHECK(report.files == contents.size());
  CHECK(report.bytes == bytes);
}

// Protects every file: one flipped bit, at the start, in the middle or at the end, is found and the
// file named; only provenance.json may change.
TEST_CASE("one flipped bit in any file is found", "[figure]") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  for (const auto& [name, content] : sample::contents(folder.path())) {
    if (content.empty()) continue;
    INFO(name);
    sample::flip_bit(folder.path() / name, content.size() / 2, 2);
    const auto found = faults(folder.path());
    REQUIRE_FALSE(found.empty());
    CHECK((mentions(found, name) || name == "dataset.json"));
    sample::write(folder.path() / name, content);
  }
  sample::flip_bit(folder.path() / "provenance.json", 3, 1);
  CHECK(faults(folder.path()).empty());
}

// Protects completeness: a missing file of any kind is found and named.
TEST_CASE("a missing file is found", "[figure]") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  for (const auto& [name, content] : sample::contents(folder.path())) {
    INFO(name);
    fs::remove(folder.path() / name);
    CHECK(mentions(faults(folder.path()), name));
    sample::write(folder.path() / name, content);
  }
}

// Protects from files that slipped in.
TEST_CASE("an unlisted file is found", "[serial]") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  const auto name = GENERATE(as<std::string>{}, "notes.txt", "sequences/000000/polar/000009.exr",
                             "sequences/000001/sequence.json", "assets/x", "splits/more.txt");
  sample::write(folder.path() / name, "x");
  const auto found = faults(folder.path());
  REQUIRE(found.size() == 1);
  CHECK(found[0] == name + ": is not listed in any manifest");
}

// Protects users from taking an unfinished data set for a whole one.
TEST_CASE("an unfinished data set is found", "[serial]") {
  const sample::TemporaryFolder folder;
  sample::open(folder.path(), 1);
  CHECK(mentions(faults(folder.path()), "not finished"));
  sample::make_dataset(folder.path(), 1);
  sample::write(folder.path() / ".work/sequences/000000/000000.json", "{}");
  CHECK(mentions(faults(folder.path()), ".work: is still there"));
}

// Protects the machine of whoever checks a data set from elsewhere: its manifests may not lead out.
TEST_CASE("paths that leave the folder are faults and not followed") {
  const sample::TemporaryFolder folder;
  const fs::path dir = folder.path() / "data";
  sample::make_dataset(dir, 1);
  sample::write(folder.path() / "outside", "x");
  SECTION("upwards from a sequence") {
    edit(dir / "sequences/000000/sequence.json", "\"poses.csv\"", "\"../../../outside\"");
  }
  SECTION("absolute from a sequence") {
    edit(dir / "sequences/000000/sequence.json", "\"poses.csv\"", "\"/etc/passwd\"");
  }
  SECTION("from the top") { edit(dir / "dataset.json", "\"index.csv\"", "\"../outside\""); }
  CHECK(mentions(faults(dir), "not a path inside the folder; not followed"));
}

// Protects from links that pass for files: the bytes behind this one are even the right ones.
TEST_CASE("links are faults and not followed", "[serial]") {
  const sample::TemporaryFolder folder;
  const fs::path dir = folder.path() / "data";
  sample::make_dataset(dir, 1);
  SECTION("a file") {
    fs::rename(dir / "sequences/000000/poses.csv", folder.path() / "poses.csv");
    fs::create_symlink(folder.path() / "poses.csv", dir / "sequences/000000/poses.csv");
    CHECK(mentions(faults(dir), "sequences/000000/poses.csv: is a link"));
  }
  SECTION("a folder") {
    fs::rename(dir / "sequences/000000/polar", folder.path() / "polar");
    fs::create_directory_symlink(folder.path() / "polar", dir / "sequences/000000/polar");
    CHECK(mentions(faults(dir), "sequences/000000/polar/000000.exr: is a link"));
  }
}

namespace {

using Change = std::function<std::string(std::string)>;

Change with(const std::string& from, const std::string& to) {
  return [=](std::string text) {
    const auto at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
  };
}
Change without(std::size_t bytes_at_end) {
  return [=](const std::string& text) { return text.substr(0, text.size() - bytes_at_end); };
}
Change ending_with(const std::string& end) {
  return [=](const std::string& text) { return text.substr(0, text.size() - end.size()) + end; };
}
std::string without_last_line(const std::string& text) {
  return text.substr(0, text.rfind('\n', text.size() - 2) + 1);
}

}  // namespace

// Protects shapes and formats where every hash is right: a data set that was made wrong.
TEST_CASE("a file of the wrong shape is found though its hash is right", "[figure]") {
  const sample::TemporaryFolder whole;
  sample::make_dataset(whole.path(), 1);
  const auto place_of = [&](const std::string& file) -> Change {
    return [&whole, file](const std::string&) {
      return sample::read(whole.path() / "sequences/000000" / file);
    };
  };
  const auto image_of = [](int samples, int beams) -> Change {
    return [=](const std::string&) { return *encode_exr(sample::image(samples, beams, 0), {}); };
  };
  const std::string beyond = {sample::kSamples * sample::kBeams, 0, 0, 0};
  const struct {
    const char* fault;
    const char* file;
    Change change;
  } cases[] = {
      {"transposed series", "timeseries/000001.npy", with("(6, 9)", "(9, 6)")},
      {"series cut short", "timeseries/000001.npy", without(1)},
      {"a picture in place of the series", "timeseries/000001.exr", place_of("polar/000001.exr")},
      {"range axis of another type", "range_m.npy", with("<f8", "<i8")},
      {"a field of the scatterers renamed", "scatterers/000000.npy", with("doppler", "Doppler")},
      {"mask of 8 bits for one of 16", "polar/000001_instance.png",
       place_of("polar/000001_semantic.png")},
      {"map of another shape", "cartesian_map.npy", with("(7, 8)", "(8, 7)")},
      {"map beyond the polar image", "cartesian_map.npy", ending_with(beyond)},
      {"map below its mark of nothing", "cartesian_map.npy", ending_with("\xff\xff\xff\x80")},
      {"polar picture in place of the Cartesian one", "cartesian/000001.exr",
       place_of("polar/000001.exr")},
      {"EXR with a row too many", "polar/000001.exr",
       image_of(sample::kSamples + 1, sample::kBeams)},
      {"EXR with a column too many", "polar/000001.exr",
       image_of(sample::kSamples, sample::kBeams + 1)},
      {"EXR channel renamed", "polar/000001.exr", with("clean_db", "cleen_db")},
      {"EXR cut short", "polar/000001.exr",
       [](const std::string& bytes) { return bytes.substr(0, bytes.size() / 2); }},
      {"a ping missing in the poses", "poses.csv", without_last_line},
      {"a number that is none", "poses.tum", with(" 2 ", " x ")},
      {"an object too many", "objects.csv",
       [](const std::string& text) { return text + "2,3,0,0,0,1,0,0,0\n"; }},
      {"a box missing", "boxes.csv", without_last_line},
      {"a point cloud cut short", "points/000001.ply", without(1)},
      {"annotations out of order", "annotations.jsonl", with("\"ping\":1", "\"ping\":2")},
      {"shadow of 8 bits for one of 16", "polar/000001_shadow.png",
       place_of("polar/000001_semantic.png")},
      {"a box that is not its mask's", "annotations.jsonl",
       with("\"bbox\":[1,0,2,3]", "\"bbox\":[1,0,2,4]")},
      {"a hidden area that is not its mask's", "annotations.jsonl",
       with("\"amodal_area\":1,", "\"amodal_area\":2,")},
  };
  for (const auto& [fault, file, change] : cases) {
    INFO(fault);
    const sample::TemporaryFolder folder;
    sample::make_dataset(folder.path(), 1);
    forge(folder.path(), file, change(sample::read(folder.path() / "sequences/000000" / file)));
    const auto found = faults(folder.path());
    REQUIRE(found.size() == 1);
    CHECK(mentions(found, std::string("sequences/000000/") + file));
  }
}

// Protects the manifest of a sequence where every hash is right.
TEST_CASE("a sequence.json that does not fit its files is found though its hash is right",
          "[serial]") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  const fs::path path = folder.path() / "sequences/000000/sequence.json";
  const std::string before = sample::read(path);
  auto json = nlohmann::ordered_json::parse(before);
  auto& files = json["files"];
  const auto bytes = [&] { return json["bytes"].get<std::uint64_t>(); };
  std::string expected;
  SECTION("a file listed twice") {
    json["bytes"] = bytes() + files[0]["bytes"].get<std::uint64_t>();
    files.push_back(files[0]);
    expected = "azimuth_rad.npy: is listed twice";
  }
  SECTION("a ping's file neither listed nor there") {
    const auto last = files.back();
    json["bytes"] = bytes() - last["bytes"].get<std::uint64_t>();
    files.erase(files.size() - 1);
    fs::remove(path.parent_path() / last["path"].get<std::string>());
    expected = "png/000002_cartesian.png: belongs to this sequence";
  }
  SECTION("a file of another kind") {
    sample::write(path.parent_path() / "notes.txt", "");
    files.push_back({{"path", "notes.txt"}, {"bytes", 0}, {"sha256", sha256_hex("")}});
    expected = "notes.txt: is listed, but not a file of this sequence";
  }
  SECTION("bytes that do not add up") {
    json["bytes"] = bytes() + 1;
    expected = "its number of bytes";
  }
  SECTION("another split than the data set's") {
    json["split"] = "test";
    expected = "differs from dataset.json";
  }
  SECTION("billions of pings") {
    json["pings"] = {0, 4000000000u};
    edit(folder.path() / "dataset.json", "0,\n        3", "0,\n        4000000000");
    expected = "lists fewer files than its pings have";
  }
  SECTION("a key missing") {
    json.erase("model");
    expected = "lacks the key model";
  }
  sample::write(path, json.dump(2));
  reseal(folder.path(), "dataset.json", sha256_hex(before), sha256_hex(sample::read(path)));
  const auto found = faults(folder.path());
  REQUIRE_FALSE(found.empty());
  CHECK(mentions(found, expected));
}

// Protects the forging itself, on which the test above stands: bytes that are as good are no fault.
TEST_CASE("a forged file that is as good is no fault", "[serial]") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  std::string series = sample::read(folder.path() / "sequences/000000/timeseries/000001.npy");
  series.back() = 1;
  forge(folder.path(), "timeseries/000001.npy", series);
  CHECK(faults(folder.path()) == std::vector<std::string>{});
}

// Protects the top-level tables where every hash is right.
TEST_CASE("tables that do not fit the pings are found though their hashes are right", "[serial]") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  const auto check = [&](const char* name, const char* from, const char* to) {
    reseal(folder.path(), name, from, to);
    const auto found = faults(folder.path());
    REQUIRE_FALSE(found.empty());
    CHECK(mentions(found, name));
  };
  SECTION("index: a ping") { check("index.csv", "\n0,1,", "\n0,7,"); }
  SECTION("index: a split") { check("index.csv", "0.1,train", "0.1,valid"); }
  SECTION("split: a stem") { check("splits/train.txt", "000000/000001", "000000/000009"); }
  SECTION("coco: a file") { check("coco.json", "png/000001_polar", "png/000009_polar"); }
  SECTION("coco: a category") { check("coco.json", "\"category_id\":2", "\"category_id\":3"); }
  SECTION("coco: an image") { check("coco.json", "\"image_id\":2", "\"image_id\":9"); }
  SECTION("coco: a mask") { check("coco.json", "\"counts\":\"7340S1\"", "\"counts\":\"7330T1\""); }
  SECTION("coco: an area") { check("coco.json", "\"area\":6", "\"area\":7"); }
  SECTION("coco: a box") { check("coco.json", "\"bbox\":[1,0,2,3]", "\"bbox\":[1,0,3,3]"); }
  SECTION("coco: a polygon") { check("coco.json", "[1,0,3,0,3,3,1,3]", "[1,0,3,0,3,2,1,3]"); }
  SECTION("coco: an amodal area") { check("coco.json", "\"amodal_area\":9", "\"amodal_area\":8"); }
  SECTION("coco: an amodal mask") { check("coco.json", "734000l0", "7340S1"); }
  SECTION("coco: a share") { check("coco.json", "\"occlusion\":0.25", "\"occlusion\":1.25"); }
  SECTION("coco: what is hidden") { check("coco.json", "01e1", "11d1"); }
  SECTION("coco: not JSON") { check("coco.json", "\"images\":", "\"images\";"); }
  SECTION("work.json") { check("work.json", "\"seed\": 7", "\"seed\": 9"); }
  SECTION("a key of the manifest") { check("dataset.json", "\"numerics\"", "\"numerisc\""); }
  SECTION("a split of the manifest") {
    check("dataset.json", "\"split\": \"train\"", "\"split\": \"tests\"");
  }
}

// Protects the exit status: what is not a data set is a wrong command, not damage.
TEST_CASE("a folder that is no data set cannot be verified", "[serial]") {
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / "dataset.json", "{\"name\": \"somebody's\"}");
  check_fails(verify_dataset(folder.path(), Workers(1)), ErrorKind::usage);
  check_fails(verify_dataset(folder.path() / "missing", Workers(1)), ErrorKind::io);
  check_fails(verify_dataset(folder.path() / "dataset.json", Workers(1)), ErrorKind::io);
}
