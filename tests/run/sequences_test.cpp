// Sequences: worlds of their own, some of them made alone, short ones side by side.
#include <set>

#include "results.h"
#include "small_data_set.h"

using namespace ensonify;
using namespace ensonify::test;
namespace fs = std::filesystem;

namespace {

// What two sequences of a drawn world can differ in.
constexpr const char* kDrawnEachSequence = R"(ensonify: 1
name: drawn
seed: 7
sequences: 6
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 3
  beams: {count: 24, fov_deg: 24}
  rays: {elevation: 8}
materials: {m: {reflectivity: {log_uniform: [1e-4, 1e-2]}}}
objects:
  - {name: room, class: structure, material: m, shape: {box: {size_m: [5, 5, 2], inward_facing: true}}}
  - name: ball
    count: {uniform: [0, 3]}
    class: {choice: [ball, buoy]}
    material: m
    shape: {sphere: {radius_m: {uniform: [0.1, 0.3]}}}
    pose: {position_m: [{uniform: [1, 2]}, {normal: [0, 0.2]}, 0]}
trajectory: {ping_rate_hz: 5, pings: 2}
output: {cartesian: {height_px: 60}}
)";

Files of_sequence(const Files& files, const std::string& sequence) {
  Files part;
  for (const auto& [name, bytes] : files) {
    if (name.starts_with("sequences/" + sequence)) part[name] = bytes;
  }
  return part;
}

struct DrawnMaker : Maker {
  DrawnMaker() { scenario = folder.write("drawn.yaml", kDrawnEachSequence); }
};

}  // namespace

// Protects "any one of them reproduced alone": --sequences 4:5 gives sequence 4 of the whole, byte
// for byte, and the folder can be completed.
TEST_CASE("a sequence made alone is that of the whole", "[serial]") {
  const DrawnMaker maker;
  const auto whole = maker.make(maker.options("whole"));
  GenerateOptions alone = maker.options("alone");
  alone.sequences = {4, 5};
  const auto one = maker.make(alone);
  CHECK(of_sequence(one, "000004") == of_sequence(whole, "000004"));
  CHECK(of_sequence(one, "000003").empty());
  alone.sequences.reset();
  CHECK(maker.make(alone) == whole);
}

TEST_CASE("sequences that the scenario has not got are refused") {
  const DrawnMaker maker;
  GenerateOptions options = maker.options("none");
  options.sequences = {4, 7};
  check_fails(generate(options), ErrorKind::usage, {"--sequences 4:7"});
  CHECK_FALSE(fs::exists(options.output));
}

// Protects draws: worlds differ, in everything that is drawn, and not in the ids of classes.
TEST_CASE("every sequence draws its own world", "[serial]") {
  const DrawnMaker maker;
  const auto files = maker.make(maker.options("a"));
  std::set<std::string> objects;
  for (int s = 0; s < 6; ++s) {
    const std::string folder = "sequences/00000" + std::to_string(s);
    objects.insert(files.at(folder + "/objects.csv"));
    CHECK(contains(files.at(folder + "/sequence.json"),
                   "\"classes\": [\n    \"structure\",\n    \"ball\",\n    \"buoy\"\n  ]"));
  }
  CHECK(objects.size() == 6);
}

// Protects "same bytes for any threads" where several sequences are under way at once.
TEST_CASE("drawn sequences are the same for any threads, and from the data set's own scenario") {
  check_made_in_any_way(DrawnMaker());
}

// Protects data sets that grow: more draws leave the first ones as they are.
TEST_CASE("drawn sequences may grow", "[serial]") {
  const DrawnMaker maker;
  const auto whole = maker.make(maker.options("whole"));
  GenerateOptions options = maker.options("growing");
  options.input.overrides.push_back({"sequences", "2"});
  const auto two = maker.make(options);
  CHECK(of_sequence(two, "000001") == of_sequence(whole, "000001"));
  options.input.overrides.pop_back();
  CHECK(maker.make(options) == whole);
}
