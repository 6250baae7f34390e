#include "dataset/verify.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "catch.h"
#include "dataset/damage.h"
#include "dataset/sample.h"
#include "formats/exr.h"
#include "formats/sha256.h"

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
  const auto report = verify_dataset(folder.path(), Workers(2));
  REQUIRE(report.ok());
  CHECK(report->faults == std::vector<std::string>{});
  const auto contents = sample::contents(folder.path());
  std::uint64_t bytes = 0;
  for (const auto& [name, content] : contents) bytes += content.size();
  CHECK(report->files == contents.size());
  CHECK(report->bytes == bytes);
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
TEST_CASE("an unlisted file is found") {
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
TEST_CASE("an unfinished data set is found") {
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
TEST_CASE("links are faults and not followed") {
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

// Protects shapes and formats where every hash is right: a data set that was made wrong.
TEST_CASE("a file of the wrong shape is found though its hash is right") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  const fs::path dir = folder.path() / "sequences/000000";
  const auto bytes = [&](const char* name) { return sample::read(dir / name); };
  const auto changed = [&](const char* name, const std::string& from, const std::string& to) {
    std::string text = bytes(name);
    const auto at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
  };
  std::string name, forged;
  SECTION("transposed series") {
    name = "timeseries/000001.npy";
    forged = changed(name.c_str(), "(6, 9)", "(9, 6)");
  }
  SECTION("series cut short") {
    name = "timeseries/000001.npy";
    forged = bytes(name.c_str());
    forged.pop_back();
  }
  SECTION("a picture in place of the series") {
    name = "timeseries/000001.exr";
    forged = bytes("polar/000001.exr");
  }
  SECTION("range axis of another type") {
    name = "range_m.npy";
    forged = changed(name.c_str(), "<f8", "<i8");
  }
  SECTION("a field of the scatterers renamed") {
    name = "scatterers/000000.npy";
    forged = changed(name.c_str(), "doppler", "Doppler");
  }
  SECTION("mask of 8 bits for one of 16") {
    name = "polar/000001_instance.png";
    forged = bytes("polar/000001_semantic.png");
  }
  SECTION("map of another shape") {
    name = "cartesian_map.npy";
    forged = changed(name.c_str(), "(7, 8)", "(8, 7)");
  }
  SECTION("map beyond the polar image") {
    name = "cartesian_map.npy";
    forged = bytes(name.c_str());
    forged[forged.size() - 4] = sample::kSamples * sample::kBeams;
    forged[forged.size() - 3] = forged[forged.size() - 2] = forged[forged.size() - 1] = 0;
  }
  SECTION("map below its mark of nothing") {
    name = "cartesian_map.npy";
    forged = bytes(name.c_str());
    for (std::size_t i = 2; i <= 4; ++i) forged[forged.size() - i] = '\xff';
    forged.back() = '\x80';
  }
  SECTION("polar picture in place of the Cartesian one") {
    name = "cartesian/000001.exr";
    forged = bytes("polar/000001.exr");
  }
  SECTION("EXR with a row too many") {
    name = "polar/000001.exr";
    forged = *encode_exr(sample::image(sample::kSamples + 1, sample::kBeams, 0), {});
  }
  SECTION("EXR with a column too many") {
    name = "polar/000001.exr";
    forged = *encode_exr(sample::image(sample::kSamples, sample::kBeams + 1, 0), {});
  }
  SECTION("EXR channel renamed") {
    name = "polar/000001.exr";
    forged = changed(name.c_str(), "clean_db", "cleen_db");
  }
  SECTION("EXR cut short") {
    name = "polar/000001.exr";
    forged = bytes(name.c_str());
    forged.resize(forged.size() / 2);
  }
  SECTION("a ping missing in the poses") {
    name = "poses.csv";
    forged = bytes(name.c_str());
    forged.resize(forged.rfind('\n', forged.size() - 2) + 1);
  }
  SECTION("a number that is none") {
    name = "poses.tum";
    forged = changed(name.c_str(), " 2 ", " x ");
  }
  SECTION("an object too many") {
    name = "objects.csv";
    forged = bytes(name.c_str()) + "2,3,0,0,0,1,0,0,0\n";
  }
  SECTION("a box missing") {
    name = "boxes.csv";
    forged = bytes(name.c_str());
    forged.resize(forged.rfind('\n', forged.size() - 2) + 1);
  }
  SECTION("a point cloud cut short") {
    name = "points/000001.ply";
    forged = bytes(name.c_str());
    forged.pop_back();
  }
  SECTION("annotations out of order") {
    name = "annotations.jsonl";
    forged = changed(name.c_str(), "\"ping\":1", "\"ping\":2");
  }
  SECTION("shadow of 8 bits for one of 16") {
    name = "polar/000001_shadow.png";
    forged = bytes("polar/000001_semantic.png");
  }
  SECTION("a box that is not its mask's") {
    name = "annotations.jsonl";
    forged = changed(name.c_str(), "\"bbox\":[1,0,2,3]", "\"bbox\":[1,0,2,4]");
  }
  SECTION("a hidden area that is not its mask's") {
    name = "annotations.jsonl";
    forged = changed(name.c_str(), "\"amodal_area\":1,", "\"amodal_area\":2,");
  }
  forge(folder.path(), name, forged);
  const auto found = faults(folder.path());
  REQUIRE(found.size() == 1);
  CHECK(mentions(found, "sequences/000000/" + name));
}

// Protects the manifest of a sequence where every hash is right.
TEST_CASE("a sequence.json that does not fit its files is found though its hash is right") {
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
TEST_CASE("a forged file that is as good is no fault") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  std::string series = sample::read(folder.path() / "sequences/000000/timeseries/000001.npy");
  series.back() = 1;
  forge(folder.path(), "timeseries/000001.npy", series);
  CHECK(faults(folder.path()) == std::vector<std::string>{});
}

// Protects the top-level tables where every hash is right.
TEST_CASE("tables that do not fit the pings are found though their hashes are right") {
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
TEST_CASE("a folder that is no data set cannot be verified") {
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / "dataset.json", "{\"name\": \"somebody's\"}");
  const auto foreign = verify_dataset(folder.path(), Workers(1));
  REQUIRE_FALSE(foreign.ok());
  CHECK(foreign.error().kind == ErrorKind::usage);
  const auto missing = verify_dataset(folder.path() / "missing", Workers(1));
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().kind == ErrorKind::io);
  const auto file = verify_dataset(folder.path() / "dataset.json", Workers(1));
  REQUIRE_FALSE(file.ok());
  CHECK(file.error().kind == ErrorKind::io);
}
