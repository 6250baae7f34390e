#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/bench_data_sets.h"
#include "app/small_data_set.h"
#include "app/timed_data_set.h"
#include "catch.h"

using namespace ensonify;
using namespace ensonify::test;

namespace fs = std::filesystem;

namespace {

constexpr DataSetCase kTiny{"tiny", kSmall};

DataSetBenchOptions tiny_options(const fs::path& folder) {
  DataSetBenchOptions options;
  options.threads = 2;
  options.pings = 2;
  options.runs = 1;
  options.folder = folder;
  return options;
}

// Bytes on disk of a data set that `generate` makes.
double generated_bytes(const FileKind& kind) {
  const Maker maker;
  GenerateOptions options = maker.options("out");
  options.input.overrides.clear();
  if (kind.output != nullptr) options.input.overrides = {{"output", kind.output}};
  options.pings = {0, 2};
  const std::map<std::string, std::string> files = maker.make(options);
  auto bytes = static_cast<double>(fs::file_size(options.output / "provenance.json"));
  for (const auto& [name, content] : files) bytes += static_cast<double>(content.size());
  return bytes;
}

}  // namespace

// Protects the table of whole data sets: each row stands for the files that `generate` writes, its
// numbers are numbers, and programs find them all.
TEST_CASE("a bench of a tiny data set gives every kind of file") {
  const TemporaryFolder folder;
  BenchReport report;
  const auto measured = bench_data_set(kTiny, file_kinds(), tiny_options(folder.path()));
  if (!measured) FAIL(measured.error().message);
  report.data_sets = {*measured};
  const nlohmann::json tiny = nlohmann::json::parse(bench_json(report)).at("data_sets").at("tiny");
  CHECK(tiny.at("beams") == 24);
  CHECK(tiny.at("pings") == 2);
  CHECK(tiny.at("runs") == 1);
  CHECK(tiny.at("kinds").size() == file_kinds().size());
  const std::string text = bench_text(report);
  for (const FileKind& kind : file_kinds()) {
    INFO(kind.name);
    const nlohmann::json& row = tiny.at("kinds").at(kind.name);
    CHECK(row.size() == 7);
    double stages_ms = 0;
    for (const auto& [member, number] : row.items()) {
      INFO(member);
      if (member == "stages_ms") continue;
      CHECK(std::isfinite(number.get<double>()));
      CHECK(number.get<double>() > 0);
    }
    for (const auto& [stage, ms] : row.at("stages_ms").items()) stages_ms += ms.get<double>();
    // One run: its stages and the rest are all that it took.
    CHECK(stages_ms == Approx(row.at("core_ms_per_ping").get<double>()).epsilon(1e-3));
    CHECK(row.at("physics_share").get<double>() < 1);
    CHECK(text.find(kind.name) != std::string::npos);
    // Only the time in provenance.json differs, and with it the number of its digits.
    const double bytes = 2e6 * row.at("mb_per_ping").get<double>();
    CHECK(std::abs(bytes - generated_bytes(kind)) < 20);
  }
}

// Protects people's disks, also where a data set cannot be made.
TEST_CASE("a bench of data sets leaves no data set behind") {
  const TemporaryFolder folder;
  const DataSetBenchOptions options = tiny_options(folder.path());
  REQUIRE(bench_data_set(kTiny, own_files(), options).ok());
  CHECK_FALSE(fs::exists(folder.path() / "data_set"));
  const auto wrong = bench_data_set({"wrong", "ensonify: 1\nname: wrong\n"}, own_files(), options);
  REQUIRE_FALSE(wrong.ok());
  CHECK(wrong.error().kind == ErrorKind::usage);
  CHECK_FALSE(fs::exists(folder.path() / "data_set"));
}

// Protects the figures from runs of different lengths: scenarios may have few or short sequences.
TEST_CASE("a data set takes its pings from as many sequences as it needs") {
  const TemporaryFolder folder;
  DataSetBenchOptions options = tiny_options(folder.path());
  const auto pings_of = [&](const std::string& text, std::uint32_t pings) {
    options.pings = pings;
    const auto report = bench_data_set({"some", text.c_str()}, own_files(), options);
    if (!report) FAIL(report.error().message);
    return report->pings;
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
  const auto times = [&](const std::string& more, std::uint32_t pings) {
    const fs::path file = folder.path() / "varied.yaml";
    std::ofstream(file) << kSmall << more;
    const auto plan = plan_data_set({file, {}}, pings);
    if (!plan) FAIL(plan.error().message);
    return plan->times_worlds;
  };
  const std::string sampled = "scattering: {lambert_exponent: {uniform: [1, 1.1]}}\n";
  CHECK_FALSE(times("", 8));
  CHECK_FALSE(times(sampled, 4));
  CHECK(times(sampled, 8));

  const fs::path file = folder.path() / "varied.yaml";
  const auto report = bench_scenario({file, {}}, [&] {
    DataSetBenchOptions options = tiny_options(folder.path());
    options.pings = 8;
    return options;
  }());
  if (!report) FAIL(report.error().message);
  const auto stage_ms = [&](const DataSetReport& of, const char* name) {
    for (const Timing& stage : of.kinds.front().stages) {
      if (stage.name == name) return stage.ms;
    }
    return -1.0;
  };
  CHECK(stage_ms(*report, "world") > 0);
  CHECK(stage_ms(*report, "tables") > 0);
  const auto fixed = bench_data_set(kTiny, own_files(), tiny_options(folder.path()));
  if (!fixed) FAIL(fixed.error().message);
  // One world serves all sequences: its tables are there before the clock starts.
  CHECK(stage_ms(*fixed, "tables") == 0);
}

// Protects `ensonify bench SCENARIO`: its data set has the files and keys that were asked for.
TEST_CASE("a bench of a scenario makes that scenario's files") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "small.yaml";
  std::ofstream(file) << kSmall;
  const DataSetBenchOptions options = tiny_options(folder.path());
  const auto plain = bench_scenario({file, {}}, options);
  if (!plain) FAIL(plain.error().message);
  CHECK(plain->name == "small");
  REQUIRE(plain->kinds.size() == 1);
  CHECK(1e6 * 2 * plain->kinds[0].mb_per_ping == Approx(generated_bytes({"", nullptr})).margin(20));
  const auto series = bench_scenario({file, {{"output", file_kinds()[0].output}}}, options);
  if (!series) FAIL(series.error().message);
  CHECK(series->kinds[0].mb_per_ping < plain->kinds[0].mb_per_ping);
}

// Protects `--case`: a name chooses what it stands for, and a wrong one gets the right ones.
TEST_CASE("a case of the bench that does not exist is an error with all names") {
  const std::vector<std::string> names = bench_case_names();
  CHECK(std::count(names.begin(), names.end(), "full") == 1);
  BenchCommandOptions options;
  options.case_name = "none";
  const Status status = bench(options);
  REQUIRE_FALSE(status.ok());
  CHECK(status.error().kind == ErrorKind::usage);
  for (const std::string& name : names) {
    CHECK(status.error().message.find(name) != std::string::npos);
  }
  options.only = "growth";
  options.case_name = "wreck_survey";
  const Status other = bench(options);
  REQUIRE_FALSE(other.ok());
  CHECK(other.error().message ==
        "--case wreck_survey: expected one of threads, beams, samples, rays, objects, triangles");
}

// Protects the table from scenes that have changed their name, lost a mesh or are damaged: each is
// a scenario of the program itself, wherever that was started.
TEST_CASE("the scenes of the bench are whole") {
  const TemporaryFolder folder;
  std::vector<std::string> names;
  for (const DataSetCase& scene : data_set_cases()) {
    names.emplace_back(scene.name);
    const auto file = write_case(scene, folder.path());
    if (!file) FAIL(file.error().message);
    const auto plan = plan_data_set({*file, {}}, 24);
    if (!plan) FAIL(plan.error().message);
    const auto worlds = SequenceWorlds::open(plan->input);
    if (!worlds) FAIL(worlds.error().message);
    const std::size_t pings = worlds->first().ping_times_s.size();
    CHECK(worlds->first().scenario.sequences * pings >= 24);
    CHECK(plan->times_worlds == (scene.name != std::string("full") && pings < 24 &&
                                 scene.name != std::string("shallow_water")));
  }
  CHECK(names == std::vector<std::string>{"full", "random_debris", "wreck_survey", "rippled_seabed",
                                          "shallow_water"});
}

// Protects the figures from another configuration than the one that they are published for.
TEST_CASE("the full data set is the paper's") {
  const DataSetCase& full = data_set_cases().front();
  CHECK(std::string(full.name) == "full");
  const Result<Scenario> scenario = parse_scenario(full.text, "full", {});
  if (!scenario) FAIL(scenario.error().message);
  CHECK(scenario->sonar.beam_count == 512);
  CHECK(scenario->sonar.rays_elevation == 114);
  CHECK(scenario->sonar.range_max_m == 60);
  CHECK(scenario->sonar.bandwidth_hz == 29.9e3);
}
