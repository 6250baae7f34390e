#include "cli/bench_cases.h"
#include "cli/commands.h"

#include <algorithm>
#include <array>
#include <string>

#include "catch.h"
#include "core/sonar.h"
#include "ping/session.h"
#include "temporary_folder.h"
#include "trace/tracer.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// The groups with their scenarios in a folder.
struct Cases {
  TemporaryFolder folder;
  std::vector<TimedGroup> groups;

  explicit Cases(int threads) {
    const Status written = write_bench_files(folder.path());
    if (!written) FAIL(written.error().message);
    groups = bench_groups(folder.path(), threads, 24);
  }
  const TimedGroup& group(const std::string& name) const {
    return *std::find_if(groups.begin(), groups.end(),
                         [&](const TimedGroup& g) { return g.name == name; });
  }
};

Session session_of(const ScenarioOptions& input) {
  Result<Scenario> scenario = load_scenario(input.scenario, input.overrides);
  if (!scenario) FAIL(scenario.error().message);
  Result<Session> session = prepare_without_world(std::move(*scenario), 0);
  if (!session) FAIL(session.error().message);
  return std::move(*session);
}

double rays_of(const Sonar& sonar) {
  return double(sonar.beam_count) * sonar.rays_azimuth * sonar.rays_elevation;
}

}  // namespace

TEST_CASE("the command offers every table of the bench") {
  CHECK(bench_group_names() == std::vector<std::string>{"series", "files", "scenes", "features",
                                                        "ensemble", "threads", "beams", "samples",
                                                        "rays", "objects", "triangles"});
}

// Protects what a factor stands for: each case is the plain scene with its feature, and the
// features that change the work of synthesis are switched on.
TEST_CASE("the cases of features are one scene") {
  const Cases cases(2);
  const TimedGroup& features = cases.group("features");
  REQUIRE(features.cases.size() == 11);
  CHECK(features.cases.front().name == "plain");
  for (const TimedCase& c : features.cases) {
    INFO(c.name);
    const Session session = session_of(c.input);
    CHECK(session.sonar.beam_count == 512);
    CHECK(session.sonar.range_max_m == 10);
    CHECK(session.scenario.objects.size() == 2);
    CHECK(has_equal_beams(session.sonar) == (c.name != "unequal_beams"));
    CHECK(session.sonar.array.has_value() == (c.name == "array"));
    CHECK(session.scenario.motion_within_ping == (c.name == "motion_within_ping"));
  }
}

// Protects what is compared: realizations of the same echoes, one row of which keeps nothing else.
TEST_CASE("the cases of an ensemble are one scene, with and without files of pings") {
  const Cases cases(2);
  const TimedGroup& ensemble = cases.group("ensemble");
  REQUIRE(ensemble.cases.size() == 2);
  for (const TimedCase& c : ensemble.cases) {
    INFO(c.name);
    const Session session = session_of(c.input);
    const OutputSelection& output = session.scenario.output.selection;
    CHECK(session.ping_times_s.size() >= c.pings);
    CHECK(session.scenario.name == "speckle_wall");
    CHECK(output.statistics);
    CHECK(output.pings == (c.name == "series"));
    CHECK(output.timeseries == (c.name == "series"));
    CHECK_FALSE(output.polar);
  }
}

// Protects what the figures stand for: the numbers of the cases as they are published.
TEST_CASE("the cases of time series are the paper's") {
  const Cases cases(2);
  const TimedGroup& series = cases.group("series");
  struct Expected {
    const char* name;
    int samples;
    double rays;
  };
  const Expected expected[] = {{"full", 2392, 58368},
                               {"table1", 236, 58368},
                               {"reduced", 399, 5632},
                               {"dense", 2392, 3735552},
                               {"array", 2392, 58368}};
  REQUIRE(series.cases.size() == std::size(expected));
  for (std::size_t i = 0; i < std::size(expected); ++i) {
    INFO(expected[i].name);
    CHECK(series.cases[i].name == expected[i].name);
    const Session session = session_of(series.cases[i].input);
    CHECK(session.sonar.beam_count == 512);
    CHECK(session.record.samples == expected[i].samples);
    CHECK(rays_of(session.sonar) == expected[i].rays);
    CHECK(session.sonar.rays_per_cell == 0);
    CHECK(session.sonar.array.has_value() == (series.cases[i].name == "array"));
    if (!session.sonar.array) continue;
    CHECK(session.sonar.array->elements == 256);
    CHECK(session.sonar.array->focus == Focus::dynamic);
  }
}

// Protects the figures from an easy world: most rays meet something, in all of the record.
TEST_CASE("echoes come from all of the record at any range") {
  const Cases cases(2);
  for (const int c : {0, 2}) {
    INFO(cases.group("series").cases[c].name);
    ScenarioOptions input = cases.group("series").cases[c].input;
    input.overrides.push_back({"sonar.beams.count", "64"});
    input.overrides.push_back({"sonar.rays.elevation", "114"});
    const auto worlds = SequenceWorlds::open(input);
    if (!worlds) FAIL(worlds.error().message);
    const Session& session = worlds->first();
    const Sonar& sonar = session.sonar;
    const auto hits = worlds->first_tracer().trace_fan(make_fan(sonar), sonar_pose(session, 0),
                                                       sonar.range_max_m, Workers(2));
    std::array<int, 10> in_tenth{};
    int found = 0;
    for (const Hit& hit : hits) {
      if (hit.instance == 0) continue;
      ++found;
      ++in_tenth[std::min(9, static_cast<int>(10 * hit.range_m / sonar.range_max_m))];
    }
    CHECK(found > 0.75 * static_cast<double>(hits.size()));
    // None can lie closer than the seabed under the sonar.
    for (int tenth = 3; tenth < 10; ++tenth) {
      INFO(tenth);
      CHECK(in_tenth[tenth] > static_cast<int>(hits.size()) / 100);
    }
  }
}

// Protects the table from scenes that have changed their name, lost a mesh or are damaged: each is
// a scenario of the program itself, wherever that was started. Worlds are timed with a scene whose
// sequences have a world each.
TEST_CASE("the scenes of the bench are whole") {
  const Cases cases(2);
  std::vector<std::string> names, with_worlds;
  for (const TimedCase& scene : cases.group("scenes").cases) {
    INFO(scene.name);
    names.push_back(scene.name);
    const auto plan = plan_data_set(scene.input, scene.pings);
    if (!plan) FAIL(plan.error().message);
    if (plan->times_worlds) with_worlds.push_back(scene.name);
    const auto worlds = SequenceWorlds::open(plan->input);
    if (!worlds) FAIL(worlds.error().message);
    const std::size_t pings = worlds->first().ping_times_s.size();
    CHECK(worlds->first().scenario.sequences * pings >= scene.pings);
  }
  CHECK(names == std::vector<std::string>{"random_debris", "wreck_survey", "rippled_seabed",
                                          "shallow_water"});
  CHECK(with_worlds == std::vector<std::string>{"random_debris", "wreck_survey", "rippled_seabed"});
}

// Protects the figures from rows that are no scenario, or that do not grow.
TEST_CASE("every row of growth is a scenario, larger than the one before") {
  const Cases cases(6);
  std::vector<int> threads;
  for (const TimedGroup& group : cases.groups) {
    if (group.grows == nullptr) continue;
    INFO(group.name);
    REQUIRE(group.cases.size() >= 4);
    double last = 0;
    for (const TimedCase& c : group.cases) {
      const Session session = session_of(c.input);
      double size = 0;
      if (group.name == "threads") size = threads.emplace_back(c.threads);
      if (group.name == "beams") size = session.sonar.beam_count;
      if (group.name == "samples") size = session.record.samples;
      if (group.name == "rays") size = rays_of(session.sonar);
      if (group.name == "objects") size = static_cast<double>(session.world.instances.size());
      if (group.name == "triangles") {  // which only a world has
        const ShapeSpec& shape = session.scenario.objects.front().shape;
        size = 1 / std::get<HeightfieldSpec>(shape).cell_m;
      }
      CHECK(size > last);
      last = size;
    }
  }
  CHECK(threads == std::vector<int>{1, 2, 4, 6});
  CHECK(bench_groups({}, 1, 24)[5].cases.size() == 1);
}
