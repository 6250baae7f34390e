#include <cmath>

#include "catch.h"
#include "cli/bench_cases.h"
#include "cli/timed_data_set.h"
#include "run/small_data_set.h"

using namespace ensonify;
using namespace ensonify::test;

namespace fs = std::filesystem;

namespace {

// One run of a data set of two pings by two threads.
Result<BenchTable> timed_once(const fs::path& folder, const ScenarioOptions& input,
                              std::uint32_t pings = 2) {
  return time_group({"some", "", nullptr, {{"case", input, 2, pings}}}, folder, 1);
}

// Bytes on disk of a data set that `generate` makes.
double generated_bytes(const std::vector<Override>& overrides) {
  const Maker maker;
  GenerateOptions options = maker.options("out");
  options.input.overrides = overrides;
  options.pings = {0, 2};
  const std::map<std::string, std::string> files = maker.make(options);
  auto bytes = static_cast<double>(fs::file_size(options.output / "provenance.json"));
  for (const auto& [name, content] : files) bytes += static_cast<double>(content.size());
  return bytes;
}

double stage_ms(const BenchRow& row, const std::string& name) {
  for (const StageMs& stage : row.stages) {
    if (stage.name == name) return stage.ms;
  }
  return -1;
}

}  // namespace

// Protects the table of whole data sets: each row stands for the files that `generate` writes, and
// its numbers are numbers.
TEST_CASE("a bench of a tiny data set gives every kind of file") {
  const TemporaryFolder folder;
  const fs::path small = folder.write("small.yaml", kSmall);
  TimedGroup group = bench_groups(folder.path(), 2, 2)[1];
  CHECK(group.name == "files");
  CHECK(group.cases.size() == 18);
  for (TimedCase& kind : group.cases) kind.input.scenario = small;
  const auto table = time_group(group, folder.path(), 1);
  if (!table) FAIL(table.error().message);
  REQUIRE(table->rows.size() == group.cases.size());
  for (std::size_t i = 0; i < group.cases.size(); ++i) {
    const BenchRow& row = table->rows[i];
    INFO(row.name);
    CHECK(row.name == group.cases[i].name);
    CHECK(row.sizes.beams == 24);
    CHECK(row.sizes.rays == 24 * 8);
    CHECK(row.sizes.threads == 2);
    CHECK(row.pings == 2);
    for (const double number : {row.pings_per_s, row.core_ms_per_ping, row.world_core_ms}) {
      CHECK(std::isfinite(number));
      CHECK(number > 0);
    }
    CHECK(row.least_pings_per_s == row.pings_per_s);
    CHECK(row.most_pings_per_s == row.pings_per_s);
    // One run: its stages and the rest are all that it took.
    double stages_ms = 0;
    for (const StageMs& stage : row.stages) stages_ms += stage.ms;
    CHECK(stages_ms == Approx(row.core_ms_per_ping).epsilon(1e-3));
    CHECK(row.physics_share > 0);
    CHECK(row.physics_share < 1);
    // Only the time in provenance.json differs, and with it the number of its digits.
    const double bytes = 2e6 * row.mb_per_ping;
    CHECK(std::abs(bytes - generated_bytes(group.cases[i].input.overrides)) < 20);
  }
}

// Protects people's disks, also where a data set cannot be made.
TEST_CASE("a bench of data sets leaves no data set behind") {
  const TemporaryFolder folder;
  REQUIRE(timed_once(folder.path(), {folder.write("small.yaml", kSmall), {}}).ok());
  CHECK_FALSE(fs::exists(folder.path() / "data_set"));
  const fs::path file = folder.write("wrong.yaml", "ensonify: 1\nname: wrong\n");
  const auto wrong = timed_once(folder.path(), {file, {}});
  REQUIRE_FALSE(wrong.ok());
  CHECK(wrong.error().kind == ErrorKind::usage);
  CHECK_FALSE(fs::exists(folder.path() / "data_set"));
}

// Protects the figures from runs of different lengths: scenarios may have few or short sequences.
TEST_CASE("a data set takes its pings from as many sequences as it needs") {
  const TemporaryFolder folder;
  const auto pings_of = [&](const std::string& text, std::uint32_t pings) {
    const auto table = timed_once(folder.path(), {folder.write("some.yaml", text), {}}, pings);
    if (!table) FAIL(table.error().message);
    return table->rows.front().pings;
  };
  CHECK(pings_of(kSmall, 3) == 3);
  CHECK(pings_of(kSmall, 4) == 4);
  CHECK(pings_of(kSmall, 6) == 8);  // a sequence has 4
  CHECK(pings_of(std::string("sequences: 9\n") + kSmall, 6) == 8);
}

// Protects the figures of sampled scenes: every sequence has a world of its own, and `generate`
// builds each of them once.
TEST_CASE("worlds are part of the time where sequences have their own") {
  const TemporaryFolder folder;
  const std::string sampled = "scattering: {lambert_exponent: {uniform: [1, 1.1]}}\n";
  const fs::path fixed = folder.write("fixed.yaml", kSmall);
  const fs::path varied = folder.write("varied.yaml", kSmall + sampled);
  const auto times_worlds = [](const fs::path& file, std::uint32_t pings) {
    const auto plan = plan_data_set({file, {}}, pings);
    if (!plan) FAIL(plan.error().message);
    return plan->times_worlds;
  };
  CHECK_FALSE(times_worlds(fixed, 8));
  CHECK_FALSE(times_worlds(varied, 4));
  CHECK(times_worlds(varied, 8));

  const auto own_worlds = timed_once(folder.path(), {varied, {}}, 8);
  if (!own_worlds) FAIL(own_worlds.error().message);
  CHECK(stage_ms(own_worlds->rows.front(), "world") > 0);
  CHECK(stage_ms(own_worlds->rows.front(), "tables") > 0);
  const auto one_world = timed_once(folder.path(), {fixed, {}}, 8);
  if (!one_world) FAIL(one_world.error().message);
  // One world serves all sequences: its tables are there before the clock starts.
  CHECK(stage_ms(one_world->rows.front(), "tables") == 0);
}

// Protects the reported error: the fast backend is compared with another one, and by its own keys.
TEST_CASE("time series are compared with the reference") {
  const TemporaryFolder folder;
  const fs::path file = folder.write("small.yaml", kSmall);
  const auto error_at = [&](const char* tolerance) {
    TimedCase timed_case{"case", {file, {{"synthesis.tolerance", tolerance}}}, 2, 1};
    timed_case.compared = std::vector<Override>{{"sonar.rays.elevation", "4"}};
    const auto table = time_group({"some", "", nullptr, {timed_case}}, folder.path(), 1);
    if (!table) FAIL(table.error().message);
    REQUIRE(table->rows.front().error);
    CHECK(table->rows.front().sizes.rays == 24 * 8);  // of the ping that was timed
    return *table->rows.front().error;
  };
  const SeriesError rough = error_at("1e-4"), fine = error_at("1e-6");
  CHECK(rough.relative > fine.relative);
  CHECK(rough.relative < 1e-4);
  CHECK(fine.relative < 1e-6);
  CHECK(fine.relative > 0);
  CHECK(fine.worst_tenth >= fine.relative);
}

TEST_CASE("a bench whose results have no place is refused at once") {
  BenchCommandOptions nowhere;
  nowhere.json = "/nonexistent/bench.json";
  const Status no_file = bench(nowhere);
  REQUIRE_FALSE(no_file.ok());
  CHECK(no_file.error().kind == ErrorKind::io);
}
