// Sequences that cannot be made: the others are, in the same bytes whatever threads, shards and
// interruptions there were.
#include <string>

#include "dataset/work_folder.h"
#include "small_data_set.h"

using namespace ensonify;
using namespace ensonify::test;
namespace fs = std::filesystem;

namespace {

// Up to five balls where three or four find room: too many in some of the sequences.
constexpr const char* kCrowded = R"(ensonify: 1
name: crowded
seed: 3
sequences: 12
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 3
  beams: {count: 24, fov_deg: 24}
  rays: {elevation: 8}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: floor, class: floor, material: m, shape: {box: {size_m: [6, 6, 0.2]}}, pose: {position_m: [2, 0, -0.8]}}
  - name: ball
    count: {uniform: [1, 5]}
    class: ball
    material: m
    shape: {sphere: {radius_m: 0.3}}
    place: {on: floor, area_m: [[1.2, -0.5], [2.2, 0.5]], clearance_m: 0.1, on_failure: skip_sequence}
trajectory: {ping_rate_hz: 5, pings: 2}
output: {cartesian: {height_px: 60}}
)";

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

struct CrowdedMaker : Maker {
  explicit CrowdedMaker(const std::string& text = kCrowded) {
    scenario = folder.write("crowded.yaml", text);
  }

  // Makes what can be made; the status says what cannot.
  std::map<std::string, std::string> make_some(const GenerateOptions& o) const {
    const Status status = generate(o);
    REQUIRE_FALSE(status.ok());
    INFO(status.error().message);
    CHECK(status.error().kind == ErrorKind::incomplete);
    if (!o.shard) {
      if (const Status whole = verify(o.output, 2); !whole) FAIL(whole.error().message);
    }
    return files_of(o.output);
  }
};

std::string number_text(std::uint32_t sequence) {
  std::string text = std::to_string(sequence);
  return std::string(6 - text.size(), '0') + text;
}

}  // namespace

// Protects the night's work: one crowded sequence costs itself, is named, and leaves nothing else.
TEST_CASE("sequences without room are listed, and the others are made") {
  const CrowdedMaker maker;
  const GenerateOptions options = maker.options("a");
  const auto files = maker.make_some(options);
  const Failures failed = failures_in(options.output);
  REQUIRE(failed.size() >= 2);
  REQUIRE(failed.size() <= 10);
  for (const auto& [sequence, error] : failed) {
    CHECK(error.starts_with("objects."));
    CHECK(error.find("ball_") != std::string::npos);
  }
  for (std::uint32_t sequence = 0; sequence < 12; ++sequence) {
    const fs::path folder = options.output / "sequences" / number_text(sequence);
    CHECK(fs::exists(folder) == !failed.contains(sequence));
  }

  const Status again = generate(options);
  REQUIRE_FALSE(again.ok());
  CHECK(again.error().kind == ErrorKind::incomplete);
  CHECK(again.error().message.find(std::to_string(failed.size()) +
                                   " of 12 sequences could not be made") != std::string::npos);
  CHECK(files_of(options.output) == files);
}

// Protects "the same bytes" with failures among the sequences: dataset.json tells no machine, path
// or order of making.
TEST_CASE("failures are the same for any threads, parts and copies of the scenario") {
  const CrowdedMaker maker;
  const auto expected = maker.make_some(maker.options("a"));
  for (const int threads : {1, 5}) {
    GenerateOptions options = maker.options("threads" + std::to_string(threads));
    options.threads = threads;
    CHECK(maker.make_some(options) == expected);
  }
  SECTION("resumed") {
    GenerateOptions options = maker.options("parts");
    options.sequences = {0, 7};
    static_cast<void>(generate(options));
    options.sequences.reset();
    CHECK(maker.make_some(options) == expected);
  }
  SECTION("shards") {
    GenerateOptions options = maker.options("shards");
    for (std::uint32_t k = 0; k < 3; ++k) {
      options.shard = Shard{k, 3};
      const Status made = generate(options);
      CHECK((made.ok() || made.error().kind == ErrorKind::incomplete));
    }
    options.shard.reset();
    const Status finished = finalize_dataset(options);
    REQUIRE_FALSE(finished.ok());
    CHECK(finished.error().kind == ErrorKind::incomplete);
    CHECK(files_of(options.output) == expected);
  }
  SECTION("from the data set's own scenario") {
    GenerateOptions options = maker.options("again");
    options.input.scenario = maker.options("a").output / "scenario.yaml";
    options.input.overrides.clear();
    CHECK(maker.make_some(options) == expected);
  }
}

// Protects cheap repetition: what has failed is not tried again, also after an interruption.
TEST_CASE("a recorded failure is believed") {
  const CrowdedMaker maker;
  GenerateOptions options = maker.options("a");
  options.sequences = {0, 1};
  REQUIRE(generate(options).ok());
  REQUIRE(record_failure(options.output, {1, "recorded before"}).ok());
  options.sequences.reset();
  maker.make_some(options);
  const Failures failed = failures_in(options.output);
  REQUIRE(failed.contains(1));
  CHECK(failed.at(1) == "recorded before");
}

// Protects what no look at the ends finds: draws that contradict each other, in sequences that were
// not looked at beforehand.
TEST_CASE("sequences whose draws contradict each other are listed") {
  const CrowdedMaker maker(kContrary);
  maker.make_some(maker.options("a"));
  const Failures failed = failures_in(maker.options("a").output);
  REQUIRE(failed.size() >= 1);
  for (const auto& [sequence, error] : failed) CHECK(error.starts_with("sonar.range_m"));
}

// Protects "before anything is written": a distribution whose end no sequence may ever reach.
TEST_CASE("a distribution that leaves its key's range is refused and nothing is written") {
  const CrowdedMaker maker(std::string(kCrowded) +
                           "water: {sound_speed_m_s: {uniform: [1400, 10000.001]}}\n");
  const GenerateOptions options = maker.options("none");
  const Status status = generate(options);
  REQUIRE_FALSE(status.ok());
  CHECK(status.error().kind == ErrorKind::usage);
  INFO(status.error().message);
  CHECK(status.error().message.find("crowded.yaml:22:26: water.sound_speed_m_s: ") !=
        std::string::npos);
  CHECK(status.error().message.find("{uniform: [1400, 10000.001]} reaches it") !=
        std::string::npos);
  CHECK_FALSE(fs::exists(options.output));
}
