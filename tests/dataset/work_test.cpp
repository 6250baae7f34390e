#include "dataset/work.h"

#include <filesystem>

#include "catch.h"
#include "dataset/sample.h"
#include "results.h"

using namespace ensonify;
namespace fs = std::filesystem;

namespace {

FolderState open_state(const fs::path& dir, const WorkIdentity& identity, std::uint32_t sequences,
                       bool overwrite = false) {
  return value_of(open_work(dir, identity, sequences, overwrite));
}

std::string refusal(const fs::path& dir, const WorkIdentity& identity, std::uint32_t sequences,
                    bool overwrite = false) {
  const auto state = open_work(dir, identity, sequences, overwrite);
  REQUIRE_FALSE(state.ok());
  CHECK(state.error().kind == ErrorKind::usage);
  return state.error().message;
}

}  // namespace

// Protects "the same work": equal bytes for equal identities, other bytes if any member differs.
TEST_CASE("work.json tells identities apart") {
  const std::string text = to_json(sample::identity());
  CHECK(text == to_json(sample::identity()));
  std::vector<WorkIdentity> others(11, sample::identity());
  others[0].name = "other";
  others[1].scenario_sha256 = std::string(64, 'b');
  others[2].seed = 8;
  others[3].first_ping = 1;
  others[4].last_ping = 99;
  others[5].program_version = "0.2.0";
  others[6].program_commit = "fedcba";
  others[7].backend = "cuda";
  others[8].simd = "avx512";
  others[9].embree_isa = "SSE4.2";
  others[10].seed = 18446744073709551615u;
  for (const WorkIdentity& other : others) CHECK(to_json(other) != text);
  CHECK(contains(to_json(others[10]), "18446744073709551615"));
}

// Protects the life of a folder: new or empty is started, and from then on continued.
TEST_CASE("a new folder is started and then continued") {
  const sample::TemporaryFolder folder;
  const fs::path dir = folder.path() / "not/there/yet";
  CHECK(open_state(dir, sample::identity(), 1) == FolderState::started);
  CHECK(sample::read(dir / "work.json") == to_json(sample::identity()));
  CHECK(open_state(dir, sample::identity(), 1) == FolderState::continued);

  fs::create_directories(folder.path() / "empty");
  CHECK(open_state(folder.path() / "empty", sample::identity(), 1) == FolderState::started);
}

// Protects a start that was killed before work.json had its name: the folder is still a new one.
TEST_CASE("temporary files of a killed start do not make a folder foreign") {
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / ".work/tmp/123-abc", "{\"ensonify_wo");
  CHECK(open_state(folder.path(), sample::identity(), 1) == FolderState::started);
}

// Protects finished data sets: complete when whole and asked for as it is, and then untouched.
TEST_CASE("a finished data set is complete and left alone") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 2);
  const auto before = sample::contents(folder.path());
  CHECK(open_state(folder.path(), sample::identity(), 2) == FolderState::complete);
  CHECK(sample::contents(folder.path()) == before);
}

// Protects the end of a run that was killed between the seal and the removal of .work.
TEST_CASE("a .work left behind a complete data set is removed") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  sample::write(folder.path() / ".work/sequences/000000/000000.json", "{}");
  sample::write(folder.path() / ".work/tmp/1-2", "x");
  CHECK(open_state(folder.path(), sample::identity(), 1) == FolderState::complete);
  CHECK_FALSE(fs::exists(folder.path() / ".work"));
}

// Protects against taking a half-finished finishing step for a complete data set.
TEST_CASE("a data set without a seal that agrees is continued") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  const std::string seal = sample::read(folder.path() / "dataset.sha256");
  SECTION("seal missing") { fs::remove(folder.path() / "dataset.sha256"); }
  SECTION("seal of another manifest") { sample::flip_bit(folder.path() / "dataset.sha256", 0, 0); }
  SECTION("manifest changed") { sample::flip_bit(folder.path() / "dataset.json", 40, 0); }
  SECTION("manifest missing") { fs::remove(folder.path() / "dataset.json"); }
  CHECK(open_state(folder.path(), sample::identity(), 1) == FolderState::continued);
}

// Protects the growth of a data set, and that it does not shrink unasked.
TEST_CASE("sequences may grow but not shrink") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 2);
  CHECK(open_state(folder.path(), sample::identity(), 3) == FolderState::continued);
  const std::string message = refusal(folder.path(), sample::identity(), 1);
  CHECK(contains(message, "2 sequences"));
  CHECK(contains(message, "--overwrite"));
}

// Protects the same for sequences that were begun and never sealed.
TEST_CASE("sequences that were begun count as held") {
  const sample::TemporaryFolder folder;
  sample::open(folder.path(), 3);
  sample::write_pings(folder.path(), sample::sequence_info(2));
  CHECK(contains(refusal(folder.path(), sample::identity(), 2), "3 sequences"));
  CHECK(open_state(folder.path(), sample::identity(), 3) == FolderState::continued);
}

// Protects the user from guessing: a refusal says what differs and how to go on.
TEST_CASE("other work is refused with what differs") {
  const sample::TemporaryFolder folder;
  sample::open(folder.path(), 1);
  WorkIdentity other = sample::identity();
  other.seed = 8;
  other.program_version = "0.2.0";
  other.last_ping = 99;
  other.backend = "cuda";
  const std::string message = refusal(folder.path(), other, 1);
  CHECK(contains(message, "seed (7, now 8)"));
  CHECK(contains(message, "version (\"0.1.0\", now \"0.2.0\")"));
  CHECK(contains(message, "pings ([0,3], now [0,99])"));
  CHECK(contains(message, "backend (\"cpu\", now \"cuda\")"));
  CHECK_FALSE(contains(message, "SIMD"));
  CHECK(contains(message, "--overwrite"));
  other = sample::identity();
  other.scenario_sha256 = std::string(64, 'b');
  CHECK(contains(refusal(folder.path(), other, 1), "differs in scenario;"));
}

// Protects folders that are not ours, with and without --overwrite.
TEST_CASE("a folder that ensonify did not make is refused and not touched") {
  const sample::TemporaryFolder folder;
  SECTION("a file") { sample::write(folder.path() / "thesis.tex", "mine"); }
  SECTION("somebody's work.json") { sample::write(folder.path() / "work.json", "{\"a\": 1}"); }
  SECTION("a broken work.json") { sample::write(folder.path() / "work.json", "{"); }
  SECTION("somebody's dataset.json") { sample::write(folder.path() / "dataset.json", "mine"); }
  SECTION("a file in a folder") { sample::write(folder.path() / "sequences/000000/a", "mine"); }
  SECTION("a file in .work") { sample::write(folder.path() / ".work/a", "mine"); }
  const auto before = sample::contents(folder.path());
  for (const bool overwrite : {false, true}) {
    const std::string message = refusal(folder.path(), sample::identity(), 1, overwrite);
    CHECK_FALSE(contains(message, "--overwrite"));
    CHECK(sample::contents(folder.path()) == before);
  }
}

// Protects the exit status 4: a place where no folder can be.
TEST_CASE("an unwritable folder is an io error") {
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / "file", "x");
  for (const fs::path& dir :
       {folder.path() / "file", folder.path() / "file/below", fs::path("/proc/ensonify")}) {
    check_fails(open_work(dir, sample::identity(), 1, false), ErrorKind::io, {dir.string()});
  }
}

// Protects a data set that somebody took files from: its sequence must not pass for finished when
// the folder is continued, or finishing could never succeed.
TEST_CASE("a sequence that lost a file is made again when the folder is continued") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 2);
  const auto before = sample::contents(folder.path());
  fs::remove(folder.path() / "sequences/000001/timeseries/000001.npy");
  CHECK(open_state(folder.path(), sample::identity(), 3) == FolderState::continued);
  CHECK(sequence_is_finished(folder.path(), 0));
  CHECK_FALSE(sequence_is_finished(folder.path(), 1));
  sample::make_dataset(folder.path(), 3);
  const auto after = sample::contents(folder.path());
  for (const auto& [name, bytes] : before) {
    INFO(name);
    if (name.starts_with("sequences/")) CHECK(after.at(name) == bytes);
  }
}

// Protects what lies behind a link: neither removed nor written over, whether asked to overwrite or
// not.
TEST_CASE("links in the place of our folders are refused and what they lead to stays") {
  const sample::TemporaryFolder folder, other;
  sample::make_dataset(other.path(), 1);
  sample::write(other.path() / ".work/sequences/000000/mine.json", "mine");
  const auto before = sample::contents(other.path());
  const fs::path dir = folder.path() / "d";
  sample::open(dir, 2);
  std::string name;
  SECTION("of .work") { fs::remove_all(dir / (name = ".work")); }
  SECTION("of the sequences") { name = "sequences"; }
  SECTION("of one sequence") { name = "sequences/000000"; }
  SECTION("of the pictures of one") { name = "sequences/000000/polar"; }
  SECTION("of the records of one") { name = ".work/sequences/000000"; }
  fs::create_directories((dir / name).parent_path());
  fs::create_directory_symlink(other.path() / name, dir / name);
  for (const bool overwrite : {false, true}) {
    INFO(name << (overwrite ? ", overwrite" : ""));
    CHECK(
        contains(refusal(dir, sample::identity(), 2, overwrite), "`" + name + "` in it is a link"));
    WorkIdentity another = sample::identity();
    another.seed = 99;
    refusal(dir, another, 2, overwrite);
  }
  CHECK(sample::contents(other.path()) == before);
}

// Protects the one that is at work: what it has made is not taken from under it, and what it goes
// on to make does not come into another's data set.
TEST_CASE("a folder in which another is at work is not emptied") {
  const sample::TemporaryFolder folder;
  WorkIdentity other = sample::identity();
  other.seed = 99;
  {
    FolderUse one, two;
    REQUIRE(open_work(folder.path(), sample::identity(), 1, false, false, &one).ok());
    REQUIRE(open_work(folder.path(), sample::identity(), 1, false, false, &two).ok());
    CHECK(contains(refusal(folder.path(), other, 1, true), "another process is writing"));
    one = FolderUse();
    CHECK(contains(refusal(folder.path(), other, 1, true), "another process is writing"));
    // The same work is gone on with, by however many.
    CHECK(open_state(folder.path(), sample::identity(), 1, true) == FolderState::continued);
  }
  CHECK(open_state(folder.path(), other, 1, true) == FolderState::started);
}

// Protects against folders that somebody made: their number is no count of what there is to do.
TEST_CASE("a complete data set with a folder of the last number of all is complete at once") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  fs::create_directories(folder.path() / "sequences/4294967295");
  const auto state = value_of(open_work(folder.path(), sample::identity(), 1, false, true));
  CHECK(state == FolderState::complete);
}
