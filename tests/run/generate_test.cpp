// Data sets from the inside: same bytes, other bytes, going on, growing; the distance field.
#include "ping/prepare_session.h"
#include "ping/run_scene.h"
#include "ping/session.h"
#include "results.h"
#include "run/cost.h"
#include "small_data_set.h"

using namespace ensonify;
using namespace ensonify::test;
namespace fs = std::filesystem;

TEST_CASE("the same bytes for one, two and four threads") {
  const Maker maker;
  GenerateOptions one = maker.options("one");
  one.threads = 1;
  GenerateOptions four = maker.options("four");
  four.threads = 4;
  const auto expected = maker.make(maker.options("two"));
  CHECK(expected.size() > 40);
  CHECK(maker.make(one) == expected);
  CHECK(maker.make(four) == expected);
}

// Protects seeds: every drawn file changes, the labels, which hold no draw, do not.
TEST_CASE("another seed gives other series and the same labels", "[serial]") {
  const Maker maker;
  GenerateOptions other = maker.options("other");
  other.input.overrides.push_back({"seed", "8"});
  const auto a = maker.make(maker.options("a")), b = maker.make(other);
  for (const char* drawn : {"timeseries/000000.npy", "timeseries/000003.npy", "polar/000000.exr",
                            "scatterers/000001.npy", "png/000002_cartesian.png"}) {
    INFO(drawn);
    CHECK(a.at(std::string("sequences/000000/") + drawn) !=
          b.at(std::string("sequences/000000/") + drawn));
  }
  CHECK(a.at("sequences/000000/polar/000000_instance.png") ==
        b.at("sequences/000000/polar/000000_instance.png"));
  CHECK(a.at("sequences/000000/poses.csv") == b.at("sequences/000000/poses.csv"));
  CHECK(a.at("sequences/000000/timeseries/000000.npy") !=
        a.at("sequences/000000/timeseries/000001.npy"));
}

// Protects the resolved scenario: run again from the data set itself, it gives the same bytes.
TEST_CASE("a data set's own scenario makes it again", "[serial]") {
  const Maker maker;
  const auto expected = maker.make(maker.options("a"));
  CHECK(maker.make(maker.options_again("b")) == expected);
}

TEST_CASE("a complete data set is left alone, other work is refused", "[serial]") {
  const Maker maker;
  const GenerateOptions o = maker.options("a");
  maker.make(o);
  const auto stamp = fs::last_write_time(o.output / "dataset.json");
  CHECK(generate(o).ok());
  CHECK(fs::last_write_time(o.output / "dataset.json") == stamp);
  GenerateOptions other = o;
  other.input.overrides.push_back({"seed", "8"});
  check_fails(generate(other), ErrorKind::usage, {"seed", "--overwrite"});
  other.overwrite = true;
  CHECK(contains(maker.make(other).at("work.json"), "\"seed\": 8"));
}

// Protects interrupted work: half a data set, with a ping's file gone and another's record, ends in
// the bytes of an undisturbed one.
TEST_CASE("unfinished work is gone on with") {
  const Maker maker;
  const auto expected = maker.make(maker.options("whole"));
  const GenerateOptions o = maker.options("half");
  maker.make(o);
  // As a kill leaves it: no manifest, records of the pings that were done.
  fs::remove(o.output / "dataset.sha256");
  fs::remove(o.output / "dataset.json");
  const fs::path sequence = o.output / "sequences/000000";
  fs::remove(sequence / "sequence.json");
  fs::remove(sequence / "timeseries/000002.npy");
  fs::resize_file(sequence / "polar/000001.exr", 100);
  CHECK(maker.make(o) == expected);
}

// Protects data sets that grow: the first sequences keep every byte.
TEST_CASE("sequences may grow", "[serial]") {
  const Maker maker;
  const GenerateOptions small = maker.options("a");
  const auto before = maker.make(small);
  GenerateOptions grown = small;
  grown.input.overrides.push_back({"sequences", "3"});
  const auto after = maker.make(grown);
  for (const auto& [name, bytes] : before) {
    if (name.starts_with("sequences/")) CHECK(after.at(name) == bytes);
  }
  CHECK(after.at("sequences/000001/timeseries/000000.npy") !=
        after.at("sequences/000000/timeseries/000000.npy"));
  GenerateOptions fresh = maker.options("b");
  fresh.input.overrides.push_back({"sequences", "3"});
  CHECK(maker.make(fresh) == after);
}

// Protects clusters: shards in any order, one of them twice and one without a sequence, then one
// process that finishes, give the bytes of one process; nothing passes for whole before.
TEST_CASE("shards of the sequences end in the data set of one process") {
  const Maker maker;
  GenerateOptions whole = maker.options("whole");
  whole.input.overrides.push_back({"sequences", "3"});
  const auto expected = maker.make(whole);
  GenerateOptions shard = whole, last = whole;
  shard.output = last.output = maker.folder.path() / "shards";
  const auto refused = [&](const char* words) {
    check_fails(finalize_dataset(last), ErrorKind::usage, {words});
    CHECK_FALSE(fs::exists(last.output / "dataset.sha256"));
  };
  refused("contains no sequences");
  CHECK_FALSE(fs::exists(last.output));
  for (const std::size_t k : {3u, 1u, 0u}) {
    shard.shard = Shard{k, 4};
    REQUIRE(generate(shard).ok());
  }
  refused("1 of 3 sequences missing; make them with --shard or --sequences 2:3, which");
  GenerateOptions other = last;
  other.input.overrides.push_back({"seed", "8"});
  CHECK(contains(finalize_dataset(other).error().message, "seed"));

  last.partial = true;
  REQUIRE(finalize_dataset(last).ok());
  CHECK(files_of(last.output).count("sequences/000002/poses.csv") == 0);
  last.partial = false;
  for (const std::size_t k : {2u, 1u}) {
    shard.shard = Shard{k, 4};
    REQUIRE(generate(shard).ok());
  }
  REQUIRE(finalize_dataset(last).ok());
  CHECK(files_of(last.output) == expected);
  REQUIRE(finalize_dataset(last).ok());
  CHECK(files_of(last.output) == expected);
}

// Protects shards that are at work while others are finished: what they have of their sequences
// stays, and is gone on from.
TEST_CASE("finishing a part leaves alone what others have begun", "[serial]") {
  const Maker maker;
  GenerateOptions o = maker.options("parts");
  o.input.overrides.push_back({"sequences", "3"});
  for (const std::size_t k : {0u, 1u}) {
    o.shard = Shard{k, 3};
    REQUIRE(generate(o).ok());
  }
  // As a kill leaves sequence 1.
  const fs::path begun = o.output / "sequences/000001";
  fs::remove(begun / "sequence.json");
  fs::remove(begun / "timeseries/000002.npy");
  const fs::path record = o.output / ".work/sequences/000001/000000.json";
  const fs::path other = o.output / ".work/tmp/other";
  REQUIRE(fs::exists(record));
  fs::create_directories(other.parent_path());
  std::ofstream(other) << "being written";
  o.shard.reset();
  GenerateOptions partial = o;
  partial.partial = true;
  REQUIRE(finalize_dataset(partial).ok());
  CHECK(fs::exists(record));
  CHECK(fs::exists(other));
  CHECK_FALSE(fs::exists(o.output / ".work/sequences/000000"));
  GenerateOptions range = o;
  range.sequences = {0, 1};
  REQUIRE(generate(range).ok());
  CHECK(fs::exists(record));
  GenerateOptions whole = maker.options("whole");
  whole.input.overrides.push_back({"sequences", "3"});
  CHECK(maker.make(o) == maker.make(whole));
  CHECK_FALSE(fs::exists(o.output / ".work"));
}

// Protects ranges of pings: each ping is the one of the whole run, its picture's limits too.
TEST_CASE("a range of pings gives the pings of the whole", "[serial]") {
  const Maker maker;
  const auto whole = maker.make(maker.options("whole"));
  GenerateOptions part = maker.options("part");
  part.pings = {2, 4};
  const auto some = maker.make(part);
  for (const char* name : {"timeseries/000002.npy", "png/000003_polar.png", "polar/000003.exr"}) {
    const std::string path = std::string("sequences/000000/") + name;
    INFO(name);
    CHECK(some.at(path) == whole.at(path));
  }
  CHECK(some.count("sequences/000000/timeseries/000001.npy") == 0);
  part.pings = {2, 5};
  part.output = maker.folder.path() / "beyond";
  CHECK(generate(part).error().kind == ErrorKind::usage);
  CHECK_FALSE(fs::exists(part.output));
}

TEST_CASE("frozen speckle repeats in every ping, the noise does not", "[serial]") {
  const Maker maker;
  GenerateOptions o = maker.options("a");
  o.input.overrides.push_back({"scattering.speckle", "per_ray"});
  const auto noisy = maker.make(o);
  const std::string folder = "sequences/000000/";
  CHECK(noisy.at(folder + "scatterers/000000.npy") == noisy.at(folder + "scatterers/000001.npy"));
  CHECK(noisy.at(folder + "timeseries/000000.npy") != noisy.at(folder + "timeseries/000001.npy"));
}

namespace {

constexpr const char* kSceneFiles[] = {"sdf.vdb", "world.ply", "world.glb", "height_map.npy"};

GenerateOptions with_scene_files(const Maker& maker, const std::string& output) {
  GenerateOptions o = maker.options(output);
  o.input.overrides.push_back({"output.sdf.voxel_m", "0.1"});
  o.input.overrides.push_back({"output.world", "true"});
  o.input.overrides.push_back({"output.height_map.spacing_m", "0.2"});
  return o;
}

}  // namespace

// Protects the ground truth's place in the data set: listed, checked, the same bytes for any
// number of threads, counted.
TEST_CASE("distance field, meshes and height map are files of their sequence") {
  const Maker maker;
  GenerateOptions one = with_scene_files(maker, "one");
  one.threads = 1;
  const auto files = maker.make(with_scene_files(maker, "two"));
  CHECK(maker.make(one) == files);
  for (const std::string name : kSceneFiles) {
    INFO(name);
    CHECK(files.contains("sequences/000000/" + name));
    CHECK(contains(files.at("sequences/000000/sequence.json"), "\"path\":\"" + name + "\""));
    CHECK(contains(files.at("README.md"), name));
  }
  const Session session =
      prepared(load_scenario(maker.scenario, with_scene_files(maker, "").input.overrides));
  // provenance.json is not among the files read.
  CHECK(estimate_cost(session, 0).files == files.size() + 1);

  const auto plain = maker.make(maker.options("plain"));
  CHECK(plain.size() + std::size(kSceneFiles) == files.size());
}

// Protects the announced size of data sets: the meshes count with all their bytes.
TEST_CASE("meshes and height maps count in the announced size", "[serial]") {
  const Maker maker;
  const auto announced = [&](const std::vector<Override>& overrides) {
    const Session session = prepared(load_scenario(maker.scenario, overrides));
    return static_cast<double>(estimate_cost(session, 0).disk_bytes);
  };
  GenerateOptions o = maker.options("a");
  const std::vector<Override> plain = o.input.overrides;
  o.input.overrides.push_back({"output.world", "true"});
  o.input.overrides.push_back({"output.height_map.spacing_m", "0.02"});
  const auto files = maker.make(o);
  double bytes = 0;
  for (const char* name : {"world.ply", "world.glb", "height_map.npy"}) {
    bytes += static_cast<double>(files.at(std::string("sequences/000000/") + name).size());
  }
  const double more = announced(o.input.overrides) - announced(plain);
  CHECK(more > 0.95 * bytes);
  CHECK(more < 1.05 * bytes + 4000);
}

TEST_CASE("a damaged distance field is found", "[serial]") {
  const Maker maker;
  const GenerateOptions o = with_scene_files(maker, "a");
  maker.make(o);
  std::ofstream(o.output / "sequences/000000/sdf.vdb", std::ios::binary) << "no grid";
  CHECK_FALSE(verified(o.output).ok());
}

TEST_CASE("a distance field too large is refused before anything is written", "[serial]") {
  const Maker maker;
  GenerateOptions o = maker.options("a");
  o.input.overrides.push_back({"output.sdf.voxel_m", "0.00001"});
  check_fails(generate(o), ErrorKind::usage, {"output.sdf.voxel_m: "});
  CHECK_FALSE(std::filesystem::exists(o.output));
}
