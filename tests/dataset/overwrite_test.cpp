#include "dataset/overwrite.h"

#include <filesystem>

#include "catch.h"
#include "dataset/damage.h"
#include "dataset/finish.h"
#include "dataset/layout.h"
#include "dataset/sample.h"
#include "dataset/work.h"
#include "dataset/write_ping.h"
#include "results.h"

using namespace ensonify;
namespace fs = std::filesystem;

namespace {

WorkIdentity other_work() {
  WorkIdentity other = sample::identity();
  other.seed = 8;
  return other;
}

void check_refused_untouched(const fs::path& dir) {
  const auto before = sample::contents(dir);
  check_fails(open_work(dir, other_work(), 1, true), ErrorKind::usage);
  CHECK(sample::contents(dir) == before);
}

std::map<std::string, std::string> only_work(const WorkIdentity& identity) {
  return {{"work.json", to_json(identity)}};
}

}  // namespace

// Protects the user's own files beside a data set, and that all of the old data set is gone.
TEST_CASE("overwriting removes what manifests list and keeps the rest") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 2);
  sample::write(folder.path() / "notes.txt", "mine");
  sample::write(folder.path() / "sequences/000000/notes.txt", "mine too");
  sample::write(folder.path() / "sequences/000000/polar/figure.pdf", "and this");
  const auto state = value_of(open_work(folder.path(), other_work(), 1, true));
  CHECK(state == FolderState::started);
  auto expected = only_work(other_work());
  expected["notes.txt"] = "mine";
  expected["sequences/000000/notes.txt"] = "mine too";
  expected["sequences/000000/polar/figure.pdf"] = "and this";
  CHECK(sample::contents(folder.path()) == expected);
  CHECK_FALSE(fs::exists(folder.path() / "provenance.json"));
  CHECK_FALSE(fs::exists(folder.path() / "splits"));
}

// Protects the way out of work that was cut off: nothing lists its files yet but plans and records.
TEST_CASE("overwriting removes what unfinished work has written") {
  const sample::TemporaryFolder folder;
  sample::open(folder.path(), 1);
  sample::write_pings(folder.path(), sample::sequence_info(0));
  SECTION("all pings recorded") {}
  SECTION("the last ping was cut off before its record") {
    fs::remove(folder.path() / layout::record_path(0, 2));
  }
  SECTION("finishing was cut off") {
    sample::write(folder.path() / "sequences/000000/poses.csv", "x");
    sample::write(folder.path() / "index.csv", "x");
    sample::write(folder.path() / ".work/tmp/1-2", "x");
  }
  value_of(open_work(folder.path(), other_work(), 1, true));
  CHECK(sample::contents(folder.path()) == only_work(other_work()));
}

// Protects assets, whose names no fixed list has, when the finishing step was cut off.
TEST_CASE("overwriting removes planned assets") {
  const sample::TemporaryFolder folder;
  sample::open(folder.path(), 1);
  const std::string asset = "assets/" + std::string(64, 'a') + ".obj";
  REQUIRE(plan_top_level(folder.path(), {asset}).ok());
  sample::write(folder.path() / asset, "mesh");
  value_of(open_work(folder.path(), other_work(), 1, true));
  CHECK(sample::contents(folder.path()) == only_work(other_work()));
}

// Protects a stranger's file that stands where the new data set would put its own.
TEST_CASE("overwriting is refused where an unlisted file is in the way") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  SECTION("a ping that the data set does not have") {
    sample::write(folder.path() / "sequences/000000/polar/000007.exr", "mine");
  }
  SECTION("a sequence that it does not have") {
    sample::write(folder.path() / "sequences/000004/sequence.json", "mine");
  }
  SECTION("an asset") { sample::write(folder.path() / "assets/mesh.obj", "mine"); }
  SECTION("a file in place of a folder") {
    sample::write(folder.path() / "sequences/000003", "mine");
  }
  check_refused_untouched(folder.path());
}

// Protects files outside of the folder from manifests that name them.
TEST_CASE("overwriting is refused where a manifest leaves the folder") {
  const sample::TemporaryFolder folder;
  const fs::path dir = folder.path() / "data";
  sample::make_dataset(dir, 1);
  sample::write(folder.path() / "precious", "mine");
  SECTION("sequence.json, upwards") {
    damage::edit(dir / "sequences/000000/sequence.json", "\"poses.csv\"", "\"../../../precious\"");
  }
  SECTION("sequence.json, absolute") {
    damage::edit(dir / "sequences/000000/sequence.json", "\"poses.csv\"",
                 "\"" + (folder.path() / "precious").string() + "\"");
  }
  SECTION("dataset.json") {
    damage::edit(dir / "dataset.json", "\"index.csv\"", "\"../precious\"");
  }
  check_refused_untouched(dir);
  CHECK(sample::read(folder.path() / "precious") == "mine");
}

// Protects files outside of the folder from links in it.
TEST_CASE("overwriting does not follow links") {
  const sample::TemporaryFolder folder;
  const fs::path dir = folder.path() / "data";
  sample::make_dataset(dir, 1);
  fs::rename(dir / "sequences/000000/polar", folder.path() / "outside");
  fs::create_directory_symlink(folder.path() / "outside", dir / "sequences/000000/polar");
  check_fails(open_work(dir, other_work(), 1, true), ErrorKind::usage);
  CHECK(fs::exists(folder.path() / "outside/000000.exr"));
  CHECK(fs::exists(dir / "sequences/000000/timeseries/000000.npy"));
}

// Protects a removal that was killed: it can be taken up again by the other work, or the old work
// be done again, wherever it was cut. Leaving off after some of the files stands for the kill.
TEST_CASE("overwriting that was cut off can be taken up again") {
  const sample::TemporaryFolder whole;
  sample::make_dataset(whole.path(), 1);
  const auto expected = sample::contents(whole.path());
  const auto inventory = value_of(take_inventory(whole.path()));
  REQUIRE(inventory.strangers.empty());
  const auto& listed = inventory.listed;
  for (std::size_t cut = 0; cut <= listed.size(); cut += 9) {
    INFO(cut << " of " << listed.size() << " removed");
    const Inventory part{{listed.begin(), listed.begin() + static_cast<long>(cut)}, {}};
    const sample::TemporaryFolder other, again;
    for (const auto& path : {other.path(), again.path()}) {
      fs::copy(whole.path(), path, fs::copy_options::recursive);
      REQUIRE(remove_listed(path, part).ok());
    }
    value_of(open_work(other.path(), other_work(), 1, true));
    CHECK(sample::contents(other.path()) == only_work(other_work()));

    sample::make_dataset(again.path(), 1);
    CHECK(sample::contents(again.path()) == expected);
  }
}

// Protects the same at the last moment, with a stranger's file beside: the folder must still be
// known as one that ensonify made.
TEST_CASE("overwriting that was cut off before the new work.json can be taken up again") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  sample::write(folder.path() / "notes.txt", "mine");
  const auto inventory = value_of(take_inventory(folder.path()));
  CHECK(inventory.strangers == std::vector<std::string>{"notes.txt"});
  REQUIRE(remove_listed(folder.path(), inventory).ok());
  value_of(open_work(folder.path(), other_work(), 1, true));
  auto expected = only_work(other_work());
  expected["notes.txt"] = "mine";
  CHECK(sample::contents(folder.path()) == expected);
}

// Protects shards that all say --overwrite: the first empties the folder, the others go on with it;
// and a data set that is complete is made anew on request.
TEST_CASE("overwriting the same work restarts it only if it was complete") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  const auto anew = value_of(open_work(folder.path(), sample::identity(), 1, true));
  CHECK(anew == FolderState::started);
  CHECK(sample::contents(folder.path()) == only_work(sample::identity()));

  sample::write_pings(folder.path(), sample::sequence_info(0));
  const auto shard = value_of(open_work(folder.path(), sample::identity(), 1, true));
  CHECK(shard == FolderState::continued);
  CHECK(ping_is_finished(folder.path(), 0, 2, sample::sequence_info(0)));
}
