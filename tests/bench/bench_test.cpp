#include "bench/bench.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "catch.h"
#include "core/units.h"
#include "trace/tracer.h"

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

// Protects what the figures stand for: the numbers of the cases as they are published.
TEST_CASE("the cases are the paper's") {
  const std::vector<BenchCase> cases = bench_cases();
  REQUIRE(cases.size() == 5);
  const auto record = [](const BenchCase& c) { return make_record(c.sonar, c.water, 0); };
  CHECK(record(cases[0]).samples == 2392);
  CHECK(record(cases[0]).transform == 2500);
  CHECK(record(cases[1]).samples == 236);
  CHECK(record(cases[2]).samples == 399);
  CHECK(make_fan(cases[0].sonar).size() == 58368);
  CHECK(make_fan(cases[1].sonar).size() == 58368);
  CHECK(make_fan(cases[2].sonar).size() == 5632);
  CHECK(make_fan(cases[3].sonar).size() == 3735552);
  CHECK(record(cases[4]).samples == 2392);
  CHECK(make_fan(cases[4].sonar).size() == 58368);
  REQUIRE(cases[4].sonar.array);
  CHECK(cases[4].sonar.array->elements == 256);
  CHECK(cases[4].sonar.array->focus == Focus::dynamic);
}

// Protects the figures from an easy world: nearly all rays meet something, in all of the record.
TEST_CASE("echoes come from all of the record at any range") {
  for (const int c : {0, 2}) {
    Sonar sonar = bench_cases()[c].sonar;
    const World world = make_bench_world(sonar.range_max_m);
    CHECK(std::get<MeshShape>(world.objects.front().shape).mesh->triangles.size() > 100'000);
    const Tracer tracer(world);
    sonar.beam_count = 64;
    sonar.beam_spacing_rad = radians(90) / 64;
    sonar.rays_elevation = 114;
    const auto hits =
        tracer.trace_fan(make_fan(sonar), bench_pose(), sonar.range_max_m, Workers(2));
    std::array<int, 10> in_tenth{};
    std::vector<bool> met(world.instances.size() + 1);
    int found = 0;
    for (const Hit& hit : hits) {
      met[hit.instance] = true;
      if (hit.instance == 0) continue;
      ++found;
      ++in_tenth[std::min(9, static_cast<int>(10 * hit.range_m / sonar.range_max_m))];
    }
    CHECK(found > 0.9 * static_cast<double>(hits.size()));
    // None can lie closer than the floor under the sonar.
    for (int tenth = 1; tenth < 10; ++tenth)
      CHECK(in_tenth[tenth] > static_cast<int>(hits.size()) / 20);
    for (std::size_t id = 1; id < met.size(); ++id) CHECK(met[id]);
  }
}
