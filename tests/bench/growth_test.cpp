#include <cmath>
#include <nlohmann/json.hpp>

#include "app/bench_growth.h"
#include "app/prepare_session.h"
#include "app/small_data_set.h"
#include "catch.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

double beams(const Session& session) { return session.sonar.beam_count; }

}  // namespace

TEST_CASE("an exponent is the slope over logarithms") {
  CHECK(*fitted_exponent({1, 2, 4}, {3, 12, 48}) == Approx(2));
  CHECK(*fitted_exponent({10, 100}, {7, 7}) == Approx(0).margin(1e-12));
  // Log y - 2 log x is 1, -2 and 1 in turns, which is not correlated with equal steps of log x.
  const double e = std::exp(1.0);
  CHECK(*fitted_exponent({1, 2, 4}, {e, 4 * std::exp(-2.0), 16 * e}) == Approx(2));
  CHECK_FALSE(fitted_exponent({3}, {5}).has_value());
  CHECK_FALSE(fitted_exponent({3, 3, 3}, {5, 6, 7}).has_value());
}

// Protects the table of growth: a size of the scenario, and threads, as they were used.
TEST_CASE("growth is measured over the sizes of its steps") {
  const TemporaryFolder folder;
  GrowthBenchOptions options;
  options.runs = 1;
  options.folder = folder.path();
  const DataSetCase base{"small", kSmall};
  BenchReport report;
  const auto grown = bench_growth(base,
                                  {"beams",
                                   beams,
                                   {{1, 2, {{"sonar.beams.count", "12"}}},
                                    {1, 2, {{"sonar.beams.count", "24"}}},
                                    {1, 6, {{"sonar.beams.count", "48"}}}}},
                                  options);
  if (!grown) FAIL(grown.error().message);
  const auto alone = bench_growth(base, {"threads", nullptr, {{2, 2, {}}}}, options);
  if (!alone) FAIL(alone.error().message);
  report.growth = {*grown, *alone};
  const nlohmann::json growth = nlohmann::json::parse(bench_json(report)).at("growth");
  const nlohmann::json& points = growth.at("beams").at("points");
  REQUIRE(points.size() == 3);
  const double sizes[] = {12, 24, 48};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(points[i].at("value") == sizes[i]);
    CHECK(points[i].at("pings_per_s").get<double>() > 0);
    CHECK(points[i].at("core_ms_per_ping").get<double>() > 0);
    CHECK(points[i].at("world_core_ms").get<double>() > 0);
  }
  CHECK(points[1].at("pings") == 2);
  CHECK(points[2].at("pings") == 8);  // two sequences of four
  CHECK(growth.at("beams").at("core_time_exponent").is_number());
  CHECK(growth.at("threads").at("points").at(0).at("value") == 2);
  CHECK(growth.at("threads").at("core_time_exponent").is_null());
  const std::string text = bench_text(report);
  CHECK(text.find("exponent") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "data_set"));
}

// Protects the figures from steps that are no scenario, or that do not grow.
TEST_CASE("every step of growth is a scenario, larger than the one before") {
  const TemporaryFolder folder;
  const auto file = write_case(data_set_cases().front(), folder.path());
  REQUIRE(file.ok());
  std::vector<std::string> names;
  for (const GrowthAxis& axis : growth_axes(6)) {
    names.push_back(axis.name);
    INFO(axis.name);
    REQUIRE(axis.steps.size() >= 4);
    double last = 0;
    for (const GrowthStep& step : axis.steps) {
      const Result<Scenario> scenario = load_scenario(*file, step.overrides);
      if (!scenario) FAIL(scenario.error().message);
      const Result<Session> session = prepare_without_world(*scenario, 0);
      if (!session) FAIL(session.error().message);
      double size = axis.size != nullptr ? axis.size(*session) : step.threads;
      if (axis.name == "triangles") {  // which only a world has
        size = 1 / std::get<HeightfieldSpec>(scenario->objects.front().shape).cell_m;
      }
      CHECK(size > last);
      last = size;
    }
  }
  CHECK(names ==
        std::vector<std::string>{"threads", "beams", "samples", "rays", "objects", "triangles"});
}

TEST_CASE("growth with threads ends at the number that is asked for") {
  const auto threads_of = [](int threads) {
    const GrowthAxis axis = growth_axes(threads).front();
    std::vector<int> all;
    for (const GrowthStep& step : axis.steps) all.push_back(step.threads);
    return all;
  };
  CHECK(threads_of(1) == std::vector<int>{1});
  CHECK(threads_of(2) == std::vector<int>{1, 2});
  CHECK(threads_of(6) == std::vector<int>{1, 2, 4, 6});
}
