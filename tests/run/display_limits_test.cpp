#include "run/display_limits.h"

#include <map>
#include <vector>

#include "catch.h"
#include "ping/tables.h"
#include "results.h"
#include "run/make_dataset.h"
#include "scenario/scenario.h"
#include "temporary_folder.h"

using namespace ensonify;

namespace {

const std::string kDrawn =
    "ensonify: 1\n"
    "sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 4, "
    "beams: {count: 8, fov_deg: 8}, rays: {elevation: 4}}\n"
    "materials: {m: {reflectivity: {log_uniform: [1e-5, 1e-1]}}}\n"
    "objects: [{name: room, material: m, shape: {box: {size_m: [6, 6, 3], inward_facing: "
    "true}}}]\n";

// The worlds of a scenario, some of which cannot be built, and who was asked for.
struct Source {
  test::TemporaryFolder folder;
  SequenceWorlds worlds;
  std::vector<std::uint32_t> asked;
  std::uint32_t failing_below = 0, from = 0;
  ErrorKind failure = ErrorKind::usage;

  explicit Source(const std::string& more = "") : worlds(opened(folder, kDrawn + more)) {}

  Result<std::array<double, 2>> limits_db(bool vary = true, SharedParts* first = nullptr,
                                          bool keeps_ping_zero = false) {
    asked.clear();
    const auto world = [&](std::uint32_t sequence) -> Result<ReadyWorld> {
      asked.push_back(sequence);
      if (sequence < failing_below) return Error{failure, "cannot be built"};
      return worlds.world(sequence);
    };
    return display_limits_db(worlds.first().scenario.output, {world, vary, from}, {}, Workers(2),
                             first, keeps_ping_zero);
  }

 private:
  static SequenceWorlds opened(const test::TemporaryFolder& folder, const std::string& text) {
    return value_of(SequenceWorlds::open({folder.write("scene.yaml", text), {}}));
  }
};

using Asked = std::vector<std::uint32_t>;

}  // namespace

// Protects one display for a data set: which pings decide on it, whatever is made of the rest.
TEST_CASE("limits come from the first two sequences that can be made") {
  Source source;
  const auto limits = value_of(source.limits_db());
  CHECK(source.asked == Asked{0, 1});
  CHECK(*source.limits_db() == limits);
  source.failing_below = 3;
  CHECK(source.limits_db().ok());
  CHECK(source.asked == Asked{0, 1, 2, 3, 4});
  source.failing_below = 100;
  CHECK(*source.limits_db() == std::array<double, 2>{60, 120});
  CHECK(source.asked.size() == kProbesTried);
  // From the first that can be made on, however late that is.
  source.from = 100;
  CHECK(source.limits_db().ok());
  CHECK(source.asked == Asked{100, 101});
  source.failing_below = source.from = 0;
  CHECK(source.limits_db(false).ok());
  CHECK(source.asked == Asked{0});
}

// The second sequence has its part in them: a quieter first one alone would show the second white.
TEST_CASE("limits hold for both sequences") {
  Source source;
  const auto both = value_of(source.limits_db()), first = value_of(source.limits_db(false));
  source.failing_below = 1;
  const auto others = value_of(source.limits_db());
  CHECK(both != first);
  CHECK(both != others);
  CHECK(both[1] >= first[1] - 10);
}

// Protects from limits that another process would not get: a full disk or a lost file is no
// sequence that cannot be made.
TEST_CASE("limits are not guessed where reading fails") {
  Source source;
  source.failing_below = 1;
  source.failure = ErrorKind::io;
  REQUIRE_FALSE(source.limits_db().ok());
  CHECK(source.limits_db().error().kind == ErrorKind::io);
}

TEST_CASE("limits that are given cost no ping") {
  Source given("output: {png: {db: [11, 99]}}\n");
  CHECK(*given.limits_db() == std::array<double, 2>{11, 99});
  CHECK(given.asked.empty());
  Source none("output: {png: false}\n");
  CHECK(*none.limits_db() == std::array<double, 2>{60, 120});
  CHECK(none.asked.empty());
}

// Protects memory: a process that does not make ping 0 would hold its echoes to the end.
TEST_CASE("parts of ping 0 are kept only for whoever makes it") {
  Source source;
  for (const bool keeps : {false, true}) {
    SharedParts first;
    CHECK(source.limits_db(true, &first, keeps).ok());
    CHECK((first.ping_zero != nullptr) == keeps);
    CHECK(first.tables != nullptr);
  }
}

// Protects time: a world takes as long as several pings. One that no sequence of the work needs is
// not held.
TEST_CASE("worlds of probed sequences are built once") {
  const test::TemporaryFolder folder;
  std::map<std::uint32_t, int> sampled;
  const SequenceWorlds worlds = value_of(SequenceWorlds::open_in(
      {[&](SequenceDraw draw, ErrorPlaces places) {
         ++sampled[draw.sequence];
         return parse_scenario(kDrawn + "sequences: 3\n", "scene.yaml", {}, {}, draw, {}, places);
       },
       [](const Error& error) { return error; }, [] { return true; }},
      Error{ErrorKind::redraw, ""}));
  const Numerics numerics;
  FileHashes hashes;
  for (const std::uint32_t asked : {1u, 2u, 3u}) {
    DatasetWork work = value_of(settle_dataset(worlds, {}, PingRange{0, asked}, numerics, hashes));
    SharedParts first;
    REQUIRE(settle_display(folder.path(), worlds, numerics, Workers(1), work, first).ok());
    sampled.clear();
    CHECK(worlds.world(1).ok());
    CHECK(sampled[1] == (asked < 2));
    CHECK(worlds.world(1).ok());
    CHECK(sampled[1] == 1 + (asked < 2));
  }
}
