#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/bench_data_sets.h"
#include "app/small_data_set.h"
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
  const auto measured = bench_data_set(kTiny, tiny_options(folder.path()));
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
  REQUIRE(bench_data_set(kTiny, options).ok());
  CHECK_FALSE(fs::exists(folder.path() / "data_set"));
  const auto wrong = bench_data_set({"wrong", "ensonify: 1\nname: wrong\n"}, options);
  REQUIRE_FALSE(wrong.ok());
  CHECK(wrong.error().kind == ErrorKind::usage);
  CHECK_FALSE(fs::exists(folder.path() / "data_set"));
}

// Protects the figures from runs of different lengths: scenarios may have many short sequences.
TEST_CASE("a data set takes its pings from as many sequences as it needs") {
  const TemporaryFolder folder;
  const std::string text = std::string("sequences: 3\n") + kSmall;
  DataSetBenchOptions options = tiny_options(folder.path());
  options.pings = 6;  // each sequence has 4
  const auto report = bench_data_set({"long", text.c_str()}, options);
  if (!report) FAIL(report.error().message);
  CHECK(report->pings == 8);
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

// Protects the figures from another configuration than the one that they are published for.
TEST_CASE("the full data set is the paper's") {
  REQUIRE(data_set_cases().size() == 1);
  const DataSetCase& full = data_set_cases().front();
  CHECK(std::string(full.name) == "full");
  const Result<Scenario> scenario = parse_scenario(full.text, "full", {});
  if (!scenario) FAIL(scenario.error().message);
  CHECK(scenario->sonar.beam_count == 512);
  CHECK(scenario->sonar.rays_elevation == 114);
  CHECK(scenario->sonar.range_max_m == 60);
  CHECK(scenario->sonar.bandwidth_hz == 29.9e3);
}
