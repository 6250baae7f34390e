#include "bench/bench.h"

#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace fs = std::filesystem;

namespace {

BenchOptions tiny_options() {
  BenchCase c = bench_cases().front();
  c.name = "tiny";
  c.sonar.beam_count = 24;
  c.sonar.beam_spacing_rad = radians(24) / 24;
  c.sonar.rays_elevation = 8;
  c.sonar.range_max_m = 4;
  BenchOptions options;
  options.cases = {c};
  options.threads = 2;
  options.seconds = 0;
  options.gentle_peaks = true;
  return options;
}

const char* const kStages[] = {"trace",           "continue",       "scatterers",   "speckle",
                               "ray_sum_and_fft", "mixing",         "synthesis",    "labels",
                               "annotations",     "shadow",         "cartesian",    "grey",
                               "encode_npy",      "encode_exr",     "encode_png",   "encode_masks",
                               "sha256",          "write_data_set", "write_to_disk"};
const char* const kReferences[] = {"trace_one_ray",      "speckle_scalar", "ray_sum_direct",
                                   "ray_sum_recurrence", "mixing_full",    "fft_rows"};

}  // namespace

// Protects the programs that read the numbers: every member of the contract is there and is a
// positive number; times themselves are not judged.
TEST_CASE("a bench of a tiny case gives every figure") {
  const Result<BenchReport> report = run_bench(tiny_options());
  REQUIRE(report.ok());
  const nlohmann::json json = nlohmann::json::parse(bench_json(*report));
  const nlohmann::json& tiny = json.at("cases").at("tiny");
  for (const char* figure : {"pings_per_s", "pings_per_s_1_thread", "error", "error_worst_tenth",
                             "speedup_over_direct", "speedup_over_recurrence"}) {
    INFO(figure);
    CHECK(tiny.at(figure).get<double>() > 0);
  }
  const std::string text = bench_text(*report);
  CHECK(text.find("tiny: 24 beams x 8 rays") != std::string::npos);
  const auto require_times = [&](const nlohmann::json& times, const auto& names) {
    CHECK(times.size() == std::size(names));
    for (const char* name : names) {
      INFO(name);
      CHECK(times.at(name).template get<double>() > 0);
      CHECK(text.find(name) != std::string::npos);
    }
  };
  require_times(tiny.at("stages_ms"), kStages);
  require_times(tiny.at("references_ms"), kReferences);
  CHECK(tiny.at("error").get<double>() < 1e-5);
  CHECK(tiny.at("direct_error").get<double>() < 1e-5);
  CHECK(tiny.at("recurrence_error").get<double>() < 1e-5);
  for (const char* figure : {"fma_gflops", "copy_gb_s", "disk_mb_s"}) {
    CHECK(json.at("machine").at(figure).get<double>() > 0);
  }
  CHECK(json.at("machine").at("threads") == 2);
  CHECK(json.at("machine").at("simd").is_string());
}

// Protects people's disks: nothing is left where files were written.
TEST_CASE("a bench leaves nothing behind") {
  const fs::path folder = fs::temp_directory_path() / "ensonify_bench_test";
  fs::remove_all(folder);
  fs::create_directories(folder);
  BenchOptions options = tiny_options();
  options.disk = folder;
  REQUIRE(run_bench(options).ok());
  CHECK(fs::is_empty(folder));
  fs::remove_all(folder);
}

// All are refused before anything is measured: the whole bench would take minutes.
TEST_CASE("wrong options of the command are refused at once") {
  BenchCommandOptions unknown;
  unknown.case_name = "fulll";
  const Status wrong_case = bench(unknown);
  REQUIRE_FALSE(wrong_case.ok());
  CHECK(wrong_case.error().kind == ErrorKind::usage);
  CHECK(wrong_case.error().message.find("full, table1, reduced, dense, array") !=
        std::string::npos);

  BenchCommandOptions no_data_set;
  no_data_set.case_name = "dense";
  no_data_set.only = "data_sets";
  const Status no_such_data_set = bench(no_data_set);
  REQUIRE_FALSE(no_such_data_set.ok());
  CHECK(no_such_data_set.error().kind == ErrorKind::usage);
  CHECK(no_such_data_set.error().message.find("expected one of full") != std::string::npos);

  BenchCommandOptions nowhere;
  nowhere.json = "/nonexistent/bench.json";
  const Status no_file = bench(nowhere);
  REQUIRE_FALSE(no_file.ok());
  CHECK(no_file.error().kind == ErrorKind::io);
}
