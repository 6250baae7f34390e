#include "bench/report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/machine.h"
#include "catch.h"
#include "formats/files.h"
#include "temporary_folder.h"

using namespace ensonify;
using namespace ensonify::test;

namespace fs = std::filesystem;

TEST_CASE("the median is the middle, the lower one of two") {
  CHECK(median({3, 1, 2}) == 2);
  CHECK(median({4, 1, 3, 2}) == 2);
  CHECK(median({5}) == 5);
}

TEST_CASE("an exponent is the slope over logarithms") {
  CHECK(*fitted_exponent({1, 2, 4}, {3, 12, 48}) == Approx(2));
  CHECK(*fitted_exponent({10, 100}, {7, 7}) == Approx(0).margin(1e-12));
  // Log y - 2 log x is 1, -2 and 1 in turns, which is not correlated with equal steps of log x.
  const double e = std::exp(1.0);
  CHECK(*fitted_exponent({1, 2, 4}, {e, 4 * std::exp(-2.0), 16 * e}) == Approx(2));
  CHECK_FALSE(fitted_exponent({3}, {5}).has_value());
  CHECK_FALSE(fitted_exponent({3, 3, 3}, {5, 6, 7}).has_value());
}

// 100 samples of one beam: 1 in the first half, 1e-3 in the second but for the last tenth, which is
// too faint to be judged.
TEST_CASE("errors are relative to the record and to its tenths") {
  std::vector<std::complex<float>> exact(100, 1.0f);
  for (int n = 50; n < 100; ++n) exact[n] = n < 90 ? 1e-3f : 1e-9f;
  std::vector<std::complex<float>> series = exact;
  CHECK(series_error(series, exact, 1).relative == 0);
  for (int n = 60; n < 70; ++n) series[n] = {1e-3f, 1e-5f};
  for (int n = 90; n < 100; ++n) series[n] = 1e-7f;
  const SeriesError error = series_error(series, exact, 1);
  CHECK(error.relative == Approx(1e-5 * std::sqrt(10.0 / 50)).epsilon(1e-3));
  CHECK(error.worst_tenth == Approx(1e-2).epsilon(1e-3));
}

// Protects the programs that read the numbers, and the exponents: the core time grows as the beams,
// from the second row on as their square.
TEST_CASE("a report gives all numbers as text and as JSON") {
  const auto row = [](double beams, double core_ms) {
    BenchRow made{std::to_string(static_cast<int>(beams)),
                  {2, beams, 2392, 114 * beams, 10, 156000},
                  24,
                  45.25,
                  42.5,
                  47.5,
                  core_ms,
                  9.75,
                  300};
    made.stages = {{"trace", 7.5}, {"synthesis", 0}, {"rest", 1.25}};
    made.physics_share = 0.625;
    return made;
  };
  BenchTable plain{"series", "time series alone", nullptr, 3, {row(512, 37.5)}};
  plain.rows.front().error = SeriesError{1.6e-6, 9.7e-6};
  const BenchTable growth{
      "beams", "growth with beams", &BenchSizes::beams, 1, {row(1, 1), row(2, 2), row(4, 8)}};
  BenchReport report{{}, {plain, growth}};
  report.machine = {2, "avx512", 19.75, 1357, false, true};

  const nlohmann::json json = nlohmann::json::parse(bench_json(report));
  CHECK(json.at("machine").at("copy_gb_s") == 19.75);
  CHECK(json.at("machine").at("simd") == "avx512");
  const nlohmann::json& full = json.at("tables").at("series").at("rows").at("512");
  CHECK(full.at("samples") == 2392);
  CHECK(full.at("pings_per_s_least") == 42.5);
  CHECK(full.at("stages_ms").at("trace") == 7.5);
  CHECK(full.at("error_worst_tenth") == 9.7e-6);
  const nlohmann::json& beams = json.at("tables").at("beams");
  CHECK(beams.at("runs") == 1);
  CHECK_FALSE(beams.at("rows").at("1").contains("error"));
  CHECK(beams.at("exponents").at("core").at("all").get<double>() == Approx(1.5));
  CHECK(beams.at("exponents").at("core").at("last_two").get<double>() == Approx(2));
  CHECK(beams.at("exponents").at("world").at("all").get<double>() == Approx(0).margin(1e-12));

  const std::string text = bench_text(report);
  for (const char* part :
       {"machine: 2 threads, avx512; one core copies 19.8 GB/s; disk 1357 MB/s\n",
        "series: time series alone; medians of 3 runs\n", "512 x 2392", "42.5 to 47.5",
        "1.6e-06, 9.7e-06\n", "62 %", "  trace                     7.5\n", "medians of 1 run\n"}) {
    INFO(part);
    CHECK(text.find(part) != std::string::npos);
  }
  CHECK(text.find("  synthesis") == std::string::npos);  // no row has it
}

TEST_CASE("the machine's speeds are numbers, and the disk is left empty") {
  const TemporaryFolder folder;
  const auto machine = measure_machine(folder.path(), 3, std::size_t{1} << 20);
  REQUIRE(machine.ok());
  CHECK(machine->threads == 3);
  CHECK(std::isfinite(machine->copy_gb_s));
  CHECK(machine->copy_gb_s > 0);
  CHECK(machine->disk_mb_s > 0);
  CHECK(fs::is_empty(folder.path()));
  const auto nowhere = measure_machine("/nonexistent/place", 1, 4096);
  REQUIRE_FALSE(nowhere.ok());
  CHECK(nowhere.error().kind == ErrorKind::io);
}

TEST_CASE("a scratch folder takes its files with it, and needs a place") {
  fs::path path;
  {
    auto folder = ScratchFolder::make(fs::temp_directory_path());
    REQUIRE(folder.ok());
    path = folder->path();
    REQUIRE(write_file_atomically(path, "a/b", "text").ok());
  }
  CHECK_FALSE(fs::exists(path));
  const auto nowhere = ScratchFolder::make("/nonexistent/place");
  REQUIRE_FALSE(nowhere.ok());
  CHECK(nowhere.error().kind == ErrorKind::io);
}
