// Finishing that was stopped, repeated, or done by several at once.
#include <cstdint>
#include <filesystem>
#include <string>
#include <thread>

#include "catch.h"
#include "dataset/finish.h"
#include "dataset/sample.h"
#include "dataset/write_ping.h"
#include "results.h"

using namespace ensonify;
namespace fs = std::filesystem;

// Protects growth: top-level files are renewed, files of old sequences keep even their time stamps.
TEST_CASE("sequences grow without a touch on the old ones") {
  const sample::TemporaryFolder grown, whole;
  sample::make_dataset(grown.path(), 1);
  const fs::path old_file = grown.path() / "sequences/000000/timeseries/000000.npy";
  const fs::path old_manifest = grown.path() / "sequences/000000/sequence.json";
  const fs::file_time_type stamp{};
  fs::last_write_time(old_file, stamp);
  fs::last_write_time(old_manifest, stamp);
  sample::make_dataset(grown.path(), 3);
  sample::make_dataset(whole.path(), 3);
  CHECK(sample::contents(grown.path()) == sample::contents(whole.path()));
  CHECK(fs::last_write_time(old_file) == stamp);
  CHECK(fs::last_write_time(old_manifest) == stamp);
}

// Protects the larger one of two processes that make the same work, of which one was started with
// more sequences: whoever ends last, all sequences are in the data set.
TEST_CASE("a data set that was finished with more sequences stays") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 2);
  const auto before = sample::contents(folder.path());
  REQUIRE(finish_dataset(folder.path(), sample::dataset_info(1)).ok());
  CHECK(sample::contents(folder.path()) == before);
}

// Protects the records of the larger one while the smaller one ends.
TEST_CASE("finishing leaves alone sequences that another process has begun") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  sample::open(folder.path(), 2);
  const auto grown = sample::sequence_info(1);
  REQUIRE(write_ping(folder.path(), grown, sample::ping_result(grown, 0), Workers(1)).ok());
  REQUIRE(finish_dataset(folder.path(), sample::dataset_info(1)).ok());
  CHECK(ping_is_finished(folder.path(), 1, 0, grown));
  for (const std::uint32_t ping : {1u, 2u}) {
    REQUIRE(write_ping(folder.path(), grown, sample::ping_result(grown, ping), Workers(1)).ok());
  }
  REQUIRE(sample::finish(folder.path(), grown).ok());
  REQUIRE(finish_dataset(folder.path(), sample::dataset_info(2)).ok());
  const sample::TemporaryFolder at_once;
  sample::make_dataset(at_once.path(), 2);
  CHECK(sample::contents(folder.path()) == sample::contents(at_once.path()));
}

// Protects growth that is killed in the finishing step: the old seal must be gone before the first
// top-level file is renewed. The missing asset stops finishing in the middle.
TEST_CASE("a data set that outgrew its seal is not complete") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  sample::open(folder.path(), 2);
  sample::write_pings(folder.path(), sample::sequence_info(1));
  REQUIRE(sample::finish(folder.path(), sample::sequence_info(1)).ok());
  auto info = sample::dataset_info(2);
  info.assets = {{std::string(64, 'a'), "obj", folder.path() / "missing.obj"}};
  REQUIRE_FALSE(finish_dataset(folder.path(), info).ok());
  CHECK_FALSE(fs::exists(folder.path() / "dataset.sha256"));
}

// Protects a kill at any moment: whatever set of the latest files is missing, the same steps give
// the same data set. The order in which files appear is that of the run below.
TEST_CASE("a run that was cut off anywhere ends in the same data set") {
  const sample::TemporaryFolder whole;
  sample::make_dataset(whole.path(), 1);
  const auto expected = sample::contents(whole.path());
  const char* const last_first[] = {"dataset.sha256", "dataset.json", "provenance.json",
                                    "croissant.json", "coco.json",    "splits/val.txt",
                                    "index.csv",      "README.md"};
  const sample::TemporaryFolder folder;
  fs::copy(whole.path(), folder.path(), fs::copy_options::recursive);
  for (const char* name : last_first) {
    fs::remove(folder.path() / name);
    sample::write(folder.path() / ".work/tmp/1-2", "half");
    const sample::TemporaryFolder resumed;
    fs::copy(folder.path(), resumed.path(), fs::copy_options::recursive);
    sample::make_dataset(resumed.path(), 1);
    INFO(name);
    CHECK(sample::contents(resumed.path()) == expected);
  }
}

// Protects the same for the sequence's own end: sequence.json missing, tables there in part.
TEST_CASE("a sequence that was cut off while finishing is finished again") {
  const sample::TemporaryFolder folder, whole;
  const auto info = sample::sequence_info(0);
  sample::open(folder.path(), 1);
  sample::write_pings(folder.path(), info);
  sample::write(folder.path() / "sequences/000000/poses.csv", "stale");
  REQUIRE(sample::finish(folder.path(), info).ok());
  REQUIRE(finish_dataset(folder.path(), sample::dataset_info(1)).ok());
  sample::make_dataset(whole.path(), 1);
  CHECK(sample::contents(folder.path()) == sample::contents(whole.path()));
}

// Protects a cluster's habit of running the same work twice: two copies at once, each going through
// all the steps, end in one correct data set.
TEST_CASE("two copies of the same work end in one data set") {
  const sample::TemporaryFolder whole;
  sample::make_dataset(whole.path(), 1);
  const auto run = [](const fs::path& dir) -> std::string {
    const Workers workers(1);
    const auto state = open_work(dir, sample::identity(), 1, false);
    if (!state) return state.error().message;
    if (*state == FolderState::complete) return {};
    const auto info = sample::dataset_info(1);
    for (const std::uint32_t number : info.sequences) {
      const SequenceInfo sequence = sample::sequence_info(number);
      for (std::uint32_t ping = 0; ping < sample::kPings; ++ping) {
        const auto result = sample::ping_result(sequence, ping);
        if (const Status s = write_ping(dir, sequence, result, workers); !s) {
          return s.error().message;
        }
      }
      if (const Status s = sample::finish(dir, sequence); !s) return s.error().message;
    }
    return message_of(finish_dataset(dir, info));
  };
  for (int round = 0; round < 12; ++round) {
    const sample::TemporaryFolder folder;
    std::string first, second;
    {
      const std::jthread one([&] { first = run(folder.path()); });
      const std::jthread two([&] { second = run(folder.path()); });
    }
    REQUIRE(first == "");
    REQUIRE(second == "");
    // What the slower copy left in .work goes when the folder is opened again.
    const auto state = value_of(open_work(folder.path(), sample::identity(), 1, false));
    CHECK(state == FolderState::complete);
    CHECK(sample::contents(folder.path()) == sample::contents(whole.path()));
  }
}
