// Sequences that cannot be made: the others are, in the same bytes whatever threads, shards and
// interruptions there were.
#include <string>

#include "dataset/work_folder.h"
#include "results.h"
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
TEST_CASE("a recorded failure is believed") {
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
TEST_CASE("sequences whose draws contradict each other are listed") {
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
