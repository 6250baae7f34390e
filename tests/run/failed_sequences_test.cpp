// Sequences that cannot be made: the others are, in the same bytes whatever threads, shards and
// interruptions there were.
#include <algorithm>
#include <string>

#include "dataset/work_folder.h"
#include "ping/prepare_session.h"
#include "results.h"
#include "run/measure.h"
#include "run/sequence_worlds.h"
#include "small_data_set.h"

using namespace ensonify;
using namespace ensonify::test;
namespace fs = std::filesystem;

namespace {

// The ranges contradict each other where the first is drawn large and the second small.
constexpr const char* kContrary = R"(ensonify: 1
name: contrary
seed: 3
sequences: 25
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_min_m: {uniform: [0.2, 1.5]}
  range_max_m: {uniform: [1.2, 1.6]}
  beams: {count: 8, fov_deg: 24}
  rays: {elevation: 4}
materials: {m: {reflectivity: 1e-3}}
objects: [{name: wall, material: m, shape: {box: {size_m: [6, 6, 2], inward_facing: true}}}]
trajectory: {pings: 1}
output: {cartesian: false, png: false}
)";

// One to five balls where three or four find room.
std::string few_places(const std::string& on_failure) {
  return R"(ensonify: 1
sequences: 3
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 2, beams: {count: 4, fov_deg: 24}, rays: {elevation: 4}}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: floor, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -0.8]}}
  - name: ball
    count: {uniform: [1, 5]}
    material: m
    shape: {sphere: {radius_m: 0.3}}
    place: {on: floor, area_m: [[1.2, -0.5], [2.2, 0.5]], clearance_m: 0.1, on_failure: )" +
         on_failure + "}\n";
}

// A sequence by itself.
Result<Session> alone(const ScenarioOptions& input, std::uint32_t sequence) {
  return drawn_session({[&](SequenceDraw draw) {
                          return parse_scenario(*input.text, "s.yaml", ".", input.overrides, draw);
                        },
                        [](Scenario scenario, std::uint32_t of) {
                          return prepare_session(std::move(scenario), of);
                        }},
                       sequence);
}

// How many of the first sequences can be made; opens all of them together, and each by itself.
std::size_t check_each_alone(const ScenarioOptions& input, std::uint32_t sequences) {
  std::vector<Result<Session>> each;
  for (std::uint32_t i = 0; i < sequences; ++i) each.push_back(alone(input, i));
  const auto first =
      std::find_if(each.begin(), each.end(), [](const auto& one) { return one.ok(); });
  const Result<SequenceWorlds> worlds = SequenceWorlds::open_untraced(input);
  REQUIRE(worlds.ok() == (first != each.end()));
  if (!worlds) {
    CHECK(worlds.error().kind == ErrorKind::usage);
    CHECK(contains(worlds.error().message, "none of the first " + std::to_string(sequences)));
    return 0;
  }
  CHECK(worlds->first_sequence() == static_cast<std::uint32_t>(first - each.begin()));
  const bool ends = !each[0] && each[0].error().kind == ErrorKind::final_usage;
  CHECK(worlds->begin_at(0).ok() == !ends);
  for (std::uint32_t i = 0; i < sequences; ++i) {
    const Result<Session> session = worlds->session(i, ErrorPlaces::hidden);
    REQUIRE(session.ok() == each[i].ok());
    if (session) {
      CHECK(session->world.instances.size() == each[i]->world.instances.size());
      CHECK(session->scenario.redraw == each[i]->scenario.redraw);
    } else {
      CHECK(session.error().kind == as_usage(each[i].error()).kind);
    }
  }
  return static_cast<std::size_t>(
      std::count_if(each.begin(), each.end(), [](const auto& one) { return one.ok(); }));
}

std::vector<Override> with_seed(int seed) { return {{"seed", std::to_string(seed)}}; }

std::string number_text(std::uint32_t sequence) {
  std::string text = std::to_string(sequence);
  return std::string(6 - text.size(), '0') + text;
}

}  // namespace

// Protects the night's work: one crowded sequence costs itself, is named, and leaves nothing else.
TEST_CASE("sequences without room are listed, and the others are made") {
  const CrowdedMaker maker("skip_sequence");
  const GenerateOptions options = maker.options("a");
  const auto files = maker.make(options);
  const Failures failed = failures_in(options.output);
  REQUIRE(failed.size() >= 2);
  REQUIRE(failed.size() <= 10);
  for (const auto& [sequence, error] : failed) {
    CHECK(error.starts_with("objects."));
    CHECK(contains(error, "ball_"));
  }
  for (std::uint32_t sequence = 0; sequence < 12; ++sequence) {
    const fs::path folder = options.output / "sequences" / number_text(sequence);
    CHECK(fs::exists(folder) == !failed.contains(sequence));
  }

  check_fails(generate(options), ErrorKind::incomplete,
              {std::to_string(failed.size()) + " of 12 sequences could not be made"});
  CHECK(files_of(options.output) == files);
}

// Protects "the same bytes" with failures among the sequences: dataset.json tells no machine, path
// or order of making.
TEST_CASE("failures are the same for any threads, parts and copies of the scenario", "[figure]") {
  check_made_in_any_way(CrowdedMaker("skip_sequence"));
}

// Protects cheap repetition: what has failed is not tried again, also after an interruption.
TEST_CASE("a recorded failure is believed", "[serial]") {
  const CrowdedMaker maker("skip_sequence");
  GenerateOptions options = maker.options("a");
  options.sequences = {0, 1};
  REQUIRE(generate(options).ok());
  REQUIRE(record_failure(options.output, {1, "recorded before"}).ok());
  options.sequences.reset();
  maker.make(options);
  const Failures failed = failures_in(options.output);
  REQUIRE(failed.contains(1));
  CHECK(failed.at(1) == "recorded before");
}

// Protects what no look at the ends finds: draws that contradict each other, in sequences that were
// not looked at beforehand.
TEST_CASE("sequences whose draws contradict each other are listed", "[serial]") {
  Maker maker;
  maker.scenario = maker.folder.write("contrary.yaml", kContrary);
  maker.some_fail = true;
  maker.make(maker.options("a"));
  const Failures failed = failures_in(maker.options("a").output);
  REQUIRE(failed.size() >= 1);
  for (const auto& [sequence, error] : failed) CHECK(error.starts_with("sonar.range_m"));
}

// Protects "before anything is written": a distribution whose end no sequence may ever reach.
TEST_CASE("a distribution that leaves its key's range is refused and nothing is written") {
  const CrowdedMaker maker("skip_sequence",
                           "water: {sound_speed_m_s: {uniform: [1400, 10000.001]}}\n");
  const GenerateOptions options = maker.options("none");
  check_fails(
      generate(options), ErrorKind::usage,
      {"crowded.yaml:23:26: water.sound_speed_m_s: ", "{uniform: [1400, 10000.001]} reaches it"});
  CHECK_FALSE(fs::exists(options.output));
}

// Protects every seed and way to fail: nothing about sequence 0 is special.
TEST_CASE("a sequence is possible or not whatever the others are, for 200 seeds", "[figure]") {
  for (const auto& [on_failure, seeds] : std::vector<std::pair<std::string, int>>{
           {"skip_sequence", 200}, {"error", 50}, {"skip_object", 10}, {"redraw", 10}}) {
    INFO(on_failure);
    const std::string text = few_places(on_failure);
    std::size_t made = 0;
    for (int seed = 0; seed < seeds; ++seed) {
      INFO(seed);
      made += check_each_alone({"s.yaml", with_seed(seed), text}, 3);
    }
    const bool some_fail = on_failure == "skip_sequence" || on_failure == "error";
    CHECK((made < static_cast<std::size_t>(3 * seeds)) == some_fail);
    CHECK(made > static_cast<std::size_t>(seeds));
  }
}

TEST_CASE("a sequence whose values contradict each other is one, for 200 seeds", "[figure]") {
  std::size_t made = 0;
  for (int seed = 0; seed < 200; ++seed) {
    ScenarioOptions input{"s.yaml", with_seed(seed), kContrary};
    input.overrides.push_back({"sequences", "3"});
    made += check_each_alone(input, 3);
  }
  CHECK(made > 400);
  CHECK(made < 600);
}

// Protects from hours: what does not depend on samples is told at once, as it always was.
TEST_CASE("an error that every sequence has is one of the scenario", "[serial]") {
  const std::string text = few_places("skip_sequence");
  for (const auto& [path, value] :
       std::vector<std::pair<std::string, std::string>>{{"sonar.colour", "red"},
                                                        {"sonar.range_min_m", "3"},
                                                        {"objects.1.shape", "{plane: {}}"}}) {
    INFO(path);
    const std::vector<Override> overrides = {{"sequences", "1000000"}, {path, value}};
    const auto worlds = SequenceWorlds::open_untraced({"s.yaml", overrides, text});
    REQUIRE_FALSE(worlds.ok());
    CHECK(worlds.error().kind == ErrorKind::usage);
    CHECK_FALSE(contains(worlds.error().message, "none of the first"));
  }
}

// Protects the others from a first sequence that hears nothing, or that ends the run where it is
// not asked for.
TEST_CASE("the first sequence may fail in a later step", "[serial]") {
  Maker maker;
  std::string text = few_places("error");
  maker.scenario = maker.folder.write("few.yaml", text);
  GenerateOptions options = maker.options("later");
  int seed = 0;
  for (;; ++seed) {
    const ScenarioOptions input{"s.yaml", with_seed(seed), text};
    if (!alone(input, 0) && alone(input, 1)) break;
  }
  options.input.overrides = with_seed(seed);
  check_fails(generate(options), {"sequence 0: ", "few.yaml:6:3: ", "no free place for ball_"});
  CHECK_FALSE(fs::exists(options.output));
  options.sequences = {1, 2};
  maker.make(options);

  const char* echo = R"(ensonify: 1
sequences: 8
seed: 1
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 2, beams: {count: 4, fov_deg: 24}, rays: {elevation: 4}}
materials: {m: {reflectivity: 1e-3}}
objects: [{name: ball, material: m, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [{uniform: [1, 4]}, 0, 0]}}]
trajectory: {pings: 1}
noise: {snr_db: 20}
output: {cartesian: false, png: false}
)";
  maker.scenario = maker.folder.write("echo.yaml", echo);
  options = maker.options("echo");
  options.input.overrides = {};
  for (seed = 1;; ++seed) {
    const auto session = value_of(alone({"s.yaml", with_seed(seed), echo}, 0));
    if (session.world.objects[0].pose.position_m.x > 3) break;
  }
  options.input.overrides = with_seed(seed);
  maker.some_fail = true;
  maker.make(options);
  CHECK(failures_in(options.output).contains(0));
  const auto worlds = value_of(SequenceWorlds::open(options.input));
  const Numerics numerics;
  CHECK(measure_pings({worlds, numerics, 1}).ok());
}
