// Sequences that cannot be made: recorded, listed, verified.
#include "dataset/work_folder.h"

#include "catch.h"
#include "dataset/finish.h"
#include "dataset/verify.h"
#include "dataset/work.h"
#include "results.h"
#include "sample.h"

using namespace ensonify;
namespace fs = std::filesystem;

namespace {

// Sequence 1 of 3 cannot be made.
DatasetInfo with_a_failure() {
  DatasetInfo info = sample::dataset_info(3);
  info.sequences = {0, 2};
  info.failed = {{1, "objects.1.place: no room"}};
  info.sequences_in_all = 3;
  return info;
}

void make_all_but_one(const fs::path& dir) {
  sample::open(dir, 3);
  for (const std::uint32_t sequence : {0u, 2u}) {
    sample::write_pings(dir, sample::sequence_info(sequence));
    REQUIRE(sample::finish(dir, sample::sequence_info(sequence)).ok());
  }
  REQUIRE(record_failure(dir, {1, "objects.1.place: no room"}).ok());
}

VerifyReport verified(const fs::path& dir) { return value_of(verify_dataset(dir, Workers(2))); }

}  // namespace

// Protects "the others are made": the data set is whole without it, tells why, and is complete.
TEST_CASE("a data set is finished without a sequence that cannot be made") {
  const sample::TemporaryFolder folder;
  make_all_but_one(folder.path());
  CHECK(failures_in(folder.path()) == Failures{{1, "objects.1.place: no room"}});
  const auto finished = value_of(finish_dataset(folder.path(), with_a_failure()));
  CHECK(finished.sequences.size() == 2);
  CHECK_FALSE(fs::exists(folder.path() / ".work"));
  CHECK(failures_in(folder.path()) == Failures{{1, "objects.1.place: no room"}});

  const VerifyReport report = verified(folder.path());
  CHECK(report.faults.empty());
  CHECK(report.sequences == 2);
  REQUIRE(report.failed.size() == 1);
  CHECK(report.failed[0].sequence == 1);

  const auto state = value_of(open_work(folder.path(), sample::identity(), 3, false));
  CHECK(state == FolderState::complete);
  const auto grown = value_of(open_work(folder.path(), sample::identity(), 4, false));
  CHECK(grown == FolderState::continued);
}

// Protects against a list that contradicts the folder.
TEST_CASE("a sequence that is listed as made and as failed is damage") {
  const sample::TemporaryFolder folder;
  make_all_but_one(folder.path());
  DatasetInfo info = with_a_failure();
  SECTION("as made") { info.failed = {{2, "no room"}}; }
  SECTION("twice") { info.failed = {{1, "no room"}, {1, "no room"}}; }
  REQUIRE(finish_dataset(folder.path(), info).ok());
  const auto faults = verified(folder.path()).faults;
  CHECK(std::any_of(faults.begin(), faults.end(), [](const std::string& fault) {
    return fault.find("as failed and") != std::string::npos;
  }));
}

// Protects data sets without failures: their bytes are as before.
TEST_CASE("dataset.json has no list of failures where there are none") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 2);
  CHECK_FALSE(contains(sample::read(folder.path() / "dataset.json"), "failed"));
  CHECK(failures_in(folder.path()).empty());
}

// Protects resuming: a record that was cut short is none, so that its sequence is tried again.
TEST_CASE("a damaged record of a failure is none") {
  const sample::TemporaryFolder folder;
  sample::open(folder.path(), 3);
  sample::write(folder.path() / ".work/sequences/000001/failure.json", "{\"sequence\": 1");
  sample::write(folder.path() / ".work/sequences/000002/failure.json",
                "{\"sequence\": 1, \"error\": \"x\"}");
  CHECK(failures_in(folder.path()).empty());
  CHECK(sequence_numbers(folder.path()) == std::vector<std::uint32_t>{1, 2});
}
