// What is announced of a data set before it is made, against the data set.
#include "run/measure.h"

#include <filesystem>
#include <memory>
#include <set>

#include "run/cost.h"
#include "run/disk_room.h"
#include "run/make_dataset.h"
#include "small_data_set.h"

namespace ensonify::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPacked = "{cartesian: {height_px: 60}, one_file_per: sequence}";
constexpr const char* kMoments = "{statistics: true}";
constexpr const char* kLists = "{points: true, scatterers: true, polygons: true}";

double bytes_on_disk(const fs::path& folder) {
  double bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) bytes += static_cast<double>(entry.file_size());
  }
  return bytes;
}

struct Announced {
  Measured measured;
  double bytes = 0;
  RunTime time;
};

// All pings are measured, so that only what is left out could make a difference.
Announced announced(const ScenarioOptions& input) {
  auto worlds = SequenceWorlds::open(input);
  if (!worlds) FAIL(worlds.error().message);
  const Session& session = worlds->first();
  const Numerics numerics;
  const auto pings = static_cast<std::uint32_t>(session.ping_times_s.size());
  MeasureJob job{{0, session.scenario.sequences},
                 {},
                 pings,
                 worlds->vary(),
                 [&](std::uint32_t s) { return worlds->world(s); },
                 numerics,
                 2};
  job.seconds = 1000;
  SharedParts first;
  const auto measured = measure_pings(job, first);
  if (!measured) FAIL(measured.error().message);
  CHECK((first.tables != nullptr) !=
        worlds->vary());  // what is worked out of the first world stays
  const std::uint64_t sequences = job.count(), all = sequences * pings;
  return {*measured, disk_bytes(*measured, session, {all, sequences, all, sequences, all}),
          time_of(*measured, job)};
}

RunTime time_on(int threads, std::uint32_t sequences, std::uint32_t pings, const Measured& measured,
                bool vary = false) {
  const Numerics numerics;
  return time_of(measured, {{0, sequences}, {}, pings, vary, {}, numerics, threads});
}

}  // namespace

TEST_CASE("measured pings are spread over the run, however many there are") {
  CHECK(spread_order(0, 1, 9) == std::vector<std::uint32_t>{0});
  CHECK(spread_order(7, 9, 9) == std::vector<std::uint32_t>{7, 8});
  CHECK(spread_order(10, 111, 3) == std::vector<std::uint32_t>{10, 110, 60});
  CHECK(spread_order(3, 3, 5).empty());
  for (const std::uint32_t count : {3u, 4u, 63u, 64u, 65u, 1000u}) {
    const auto order = spread_order(5, 5 + count, count);
    const std::set<std::uint32_t> distinct(order.begin(), order.end());
    CHECK(order.size() == count);
    CHECK(distinct.size() == count);
    CHECK(*distinct.begin() == 5);
    CHECK(*distinct.rbegin() == 4 + count);
  }
}

TEST_CASE("the announced size is that of the data set") {
  const auto output =
      GENERATE(as<std::string>(), "{cartesian: {height_px: 60}}", kPacked, kMoments, kLists);
  const auto sequences = GENERATE(as<std::string>(), "1", "3");
  Maker maker;
  GenerateOptions options = maker.options("out");
  options.input.overrides = {{"output", output}, {"sequences", sequences}};
  const Announced expected = announced(options.input);
  CHECK(expected.measured.pings > 0);
  maker.make(options);
  INFO(output << " x " << sequences);
  CHECK(expected.bytes == Approx(bytes_on_disk(options.output)).epsilon(0.02));
}

TEST_CASE("the announced size is the mean of sequences that are sampled") {
  Maker maker;
  GenerateOptions options = maker.options("out");
  options.input.overrides = {{"sequences", "4"},
                             {"objects.1.shape.sphere.radius_m", "{uniform: [0.1, 0.6]}"},
                             {"trajectory.pings", "3"}};
  const Announced expected = announced(options.input);
  CHECK(expected.measured.sequences ==
        3);  // the world of sequence 0 is there: it shows no building
  CHECK(expected.measured.world_s > 0);
  maker.make(options);
  CHECK(expected.bytes == Approx(bytes_on_disk(options.output)).epsilon(0.05));
}

// The counts of an instrument are files that the scenario's output does not name.
TEST_CASE("the files of a recorder are announced") {
  Maker maker;
  GenerateOptions options = maker.options("out");
  options.input.overrides = {
      {"sonar.recorder", "{bits: 16, scale: amplitude, db: [0, 185], row_gain_db: 40}"}};
  const auto worlds = SequenceWorlds::open(options.input);
  REQUIRE(worlds.ok());
  const auto files = maker.make(options);
  REQUIRE(files.contains("sequences/000000/recorded/000000_row_gain.npy"));
  // provenance.json is not among the files read.
  CHECK(estimate_cost(worlds->first(), 0).files == files.size() + 1);
}

TEST_CASE("the announced time follows from pings, threads and sequences") {
  Measured measured;
  measured.once_s = 5;
  measured.world_s = 2;
  measured.prepare_s = 0.5;
  measured.first_ping_s = 0.25;
  measured.ping_s = 1;
  measured.cores = 1;

  // One sequence: pings side by side, of which ping 0 is partly made before.
  CHECK(time_on(1, 1, 101, measured).wall_s == Approx(5 + 0.5 + 0.25 + 100));
  CHECK(time_on(4, 1, 1000, measured).wall_s == Approx(5 + 0.5 + (0.25 + 999) / 4));
  // Three pings on two threads: one of them waits.
  measured.first_ping_s = 1;
  CHECK(time_on(2, 1, 3, measured).wall_s == Approx(5 + 0.5 + 2));
  // More threads do not make one ping faster than it is.
  CHECK(time_on(8, 1, 2, measured).wall_s == Approx(5 + 0.5 + 1));
  // Sequences of one ping, as many at once as there are threads. The first world is there.
  const RunTime many = time_on(4, 400, 1, measured, true);
  CHECK(many.core_s == Approx(5 + 399 * 2 + 400 * (0.5 + 1)));
  CHECK(many.wall_s == Approx(5 + (many.core_s - 5) / 4));
  // What is joined and finished of every ping, and what one thread lists at the end.
  measured.finish_s = 0.5;
  CHECK(time_on(1, 1, 101, measured).wall_s == Approx(5 + 0.5 + 101 + 50.5));
  measured.list_s = 0.25;
  CHECK(time_on(4, 1, 4, measured).wall_s == Approx(5 + 0.5 + 1 + 2 + 1));
}

TEST_CASE("a disk without room is an error that names both sizes") {
  CHECK(room_for_bytes("out", 5e9, std::uint64_t{5'000'000'000}).ok());
  CHECK(room_for_bytes("out", 5e9, std::nullopt).ok());
  const Status refused = room_for_bytes("out", 5e9, std::uint64_t{4'000'000'000});
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().kind == ErrorKind::io);
  CHECK(refused.error().message.starts_with(
      "out: the data needs about 5.0 GB of disk space, but only 4.0 GB is free;"));
}

TEST_CASE("free space is that of the disk on which a folder will be") {
  const TemporaryFolder folder;
  const auto there = free_bytes(folder.path());
  const auto will_be = free_bytes(folder.path() / "a/b/c");
  REQUIRE(there);
  REQUIRE(will_be);
  // Other programs write meanwhile.
  CHECK(static_cast<double>(*will_be) == Approx(static_cast<double>(*there)).epsilon(0.2));
  CHECK(fs::is_empty(folder.path()));
}

}  // namespace ensonify::test
