// Sequences that are drawn again because their objects found no room.
#include <algorithm>
#include <string>

#include "dataset/work_folder.h"
#include "formats/json.h"
#include "results.h"
#include "scenario/scenario.h"
#include "small_data_set.h"

using namespace ensonify;
using namespace ensonify::test;
namespace fs = std::filesystem;

namespace {

struct FewPlaces : CrowdedMaker {
  explicit FewPlaces(const std::string& on_failure = "redraw") : CrowdedMaker(on_failure) {}

  // The number of balls that the file gives the sequence at a draw.
  std::uint64_t balls(SequenceDraw draw) const {
    const auto drawn = value_of(load_scenario(scenario, {}, draw));
    return static_cast<std::uint64_t>(
        std::count_if(drawn.objects.begin(), drawn.objects.end(),
                      [](const ObjectSpec& spec) { return spec.class_name == "ball"; }));
  }
};

Json parsed(const std::string& text) { return value_of(parse_json(text)); }

Json sequence_json(const std::map<std::string, std::string>& files, int sequence) {
  const std::string number = std::to_string(sequence);
  return parsed(
      files.at("sequences/" + std::string(6 - number.size(), '0') + number + "/sequence.json"));
}

std::uint64_t balls_in(const Json& sequence) {
  std::uint64_t balls = 0;
  for (const Json& instance : sequence.at("instances")) balls += instance.at("class") == "ball";
  return balls;
}

}  // namespace

// Protects the night: where some draw of a sequence has room, no sequence is lost, and the manifest
// says by how much the objects that are kept differ from those that were asked for.
TEST_CASE("a sequence without room is drawn again and says so") {
  const FewPlaces maker;
  const auto files = maker.make(maker.options("a"));
  std::uint64_t redrawn = 0, redraws = 0, first = 0, kept = 0;
  for (int sequence = 0; sequence < 12; ++sequence) {
    const Json json = sequence_json(files, sequence);
    const Json& placement = json.at("placement");
    const auto number = static_cast<std::uint32_t>(sequence);
    const auto redraw = placement.at("redraws").get<std::uint32_t>();
    const Json& of_balls = placement.at("classes").at(0);
    CHECK(of_balls.at("class") == "ball");
    CHECK(of_balls.at("first") == maker.balls({number, 0}));
    CHECK(of_balls.at("kept") == maker.balls({number, redraw}));
    CHECK(balls_in(json) == of_balls.at("kept"));
    CHECK(placement.at("left_out").empty());
    redrawn += redraw > 0;
    redraws += redraw;
    first += of_balls.at("first").get<std::uint64_t>();
    kept += of_balls.at("kept").get<std::uint64_t>();
  }
  REQUIRE(redrawn >= 2);
  CHECK(kept < first);
  const Json expected = {{"sequences", 12},
                         {"redrawn", redrawn},
                         {"redraws", redraws},
                         {"left_out", 0},
                         {"classes", {{{"class", "ball"}, {"first", first}, {"kept", kept}}}}};
  CHECK(parsed(files.at("dataset.json")).at("placement") == expected);
}

// Protects reproducibility: a redraw depends on seed and sequence, not on how the work is cut.
TEST_CASE("redraws are the same for any threads, parts and copies of the scenario", "[figure]") {
  check_made_in_any_way(FewPlaces());
}

// Protects the ids of labels: they close up behind an object that is left out.
TEST_CASE("skip_object leaves out what has no room and keeps the draw", "[serial]") {
  const FewPlaces maker("skip_object");
  const auto files = maker.make(maker.options("a"));
  std::uint64_t left_out = 0;
  for (int sequence = 0; sequence < 12; ++sequence) {
    const Json json = sequence_json(files, sequence);
    const Json& placement = json.at("placement");
    const auto asked = maker.balls(static_cast<std::uint32_t>(sequence));
    CHECK(placement.at("redraws") == 0);
    CHECK(placement.at("classes").at(0).at("first") == asked);
    CHECK(balls_in(json) + placement.at("left_out").size() == asked);
    const Json& instances = json.at("instances");
    for (std::size_t i = 0; i < instances.size(); ++i) CHECK(instances.at(i).at("id") == i + 1);
    CHECK(instances.back().at("name") == "post");
    left_out += placement.at("left_out").size();
  }
  CHECK(left_out >= 2);
  CHECK(parsed(files.at("dataset.json")).at("placement").at("left_out") == left_out);
}

// Protects those who would rather know at once.
TEST_CASE("on_failure: error ends the run and names the sequence", "[serial]") {
  const FewPlaces maker("error");
  const Status status = generate(maker.options("a"));
  check_fails(status, {"sequence ", "no free place for ball_"});
  CHECK(exit_code(status.error().kind) == 2);
  CHECK_FALSE(fs::exists(maker.options("a").output / "dataset.json"));
}

// Protects a scenario that can never work from a folder full of failures.
TEST_CASE("a scenario without room in any draw is refused and nothing is written", "[serial]") {
  FewPlaces maker;
  std::string text = kCrowded;
  text.replace(text.find("{uniform: [1, 5]}"), 17, "9");
  text.replace(text.find("sequences: 12"), 13, "sequences: 2");  // each is drawn 101 times
  maker.scenario = maker.folder.write("full.yaml", text);
  check_fails(generate(maker.options("none")), ErrorKind::usage,
              {"the sequence was sampled 101 times"});
  CHECK_FALSE(fs::exists(maker.options("none").output));
}

// Protects the rest of the set from a first sequence that cannot be made.
TEST_CASE("a first sequence without room is listed and the others are made", "[serial]") {
  const FewPlaces maker("skip_sequence");
  GenerateOptions options = maker.options("a");
  const auto balls_of_first = [&](int seed) {
    const auto drawn = value_of(load_scenario(maker.scenario, {{"seed", std::to_string(seed)}}));
    return drawn.objects.size() - 2;
  };
  int seed = 1;
  while (balls_of_first(seed) < 5) ++seed;
  options.input.overrides.push_back({"seed", std::to_string(seed)});
  check_fails(generate(options), ErrorKind::incomplete);
  const Failures failed = failures_in(options.output);
  CHECK(failed.contains(0));
  CHECK(failed.size() < 12);
  CHECK(verified(options.output).ok());
}
