// Small data sets in a folder of their own.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "catch.h"
#include "results.h"
#include "run/runs.h"
#include "temporary_folder.h"
#include "verified.h"

namespace ensonify::test {

inline constexpr const char* kSmall = R"(ensonify: 1
name: small
seed: 7
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 3
  beams: {count: 24, fov_deg: 24}
  rays: {elevation: 8}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: room, class: structure, material: m, shape: {box: {size_m: [5, 5, 2], inward_facing: true}}}
  - {name: ball, class: ball, material: m, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [1.5, 0, 0]}}
point_targets: [{name: p, target_strength_db: -40, position_m: [1, 0.3, 0]}]
trajectory: {ping_rate_hz: 5, pings: 4}
noise: {spectrum_level_db: 40}
output: {cartesian: {height_px: 60}}
)";

using Files = std::map<std::string, std::string>;

inline Files files_of(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = fs::relative(entry.path(), folder).string();
    if (name == "provenance.json") continue;
    std::ifstream stream(entry.path(), std::ios::binary);
    files[name] = std::string(std::istreambuf_iterator<char>(stream), {});
  }
  return files;
}

struct Maker {
  TemporaryFolder folder;
  std::filesystem::path scenario = folder.write("small.yaml", kSmall);
  bool some_fail = false;  // some sequences cannot be made: the data set ends as incomplete

  GenerateOptions options(const std::string& output) const {
    GenerateOptions o;
    o.input.scenario = scenario;
    o.input.overrides = {{"output.scatterers", "true"}};
    o.output = folder.path() / output;
    o.threads = 2;
    o.quiet = true;
    return o;
  }
  // Of the scenario that the data set "a" holds.
  GenerateOptions options_again(const std::string& output) const {
    GenerateOptions o = options(output);
    o.input.scenario = options("a").output / "scenario.yaml";
    o.input.overrides.clear();
    return o;
  }
  void check_end(const Status& status) const {
    if (some_fail) {
      check_fails(status, ErrorKind::incomplete);
    } else if (!status) {
      FAIL(status.error().message);
    }
  }
  Files make(const GenerateOptions& o) const {
    check_end(generate(o));
    require_ok(verified(o.output));
    return files_of(o.output);
  }
};

// The bytes of the data set do not depend on threads, interruptions or shards, and its own scenario
// makes it again.
inline void check_made_in_any_way(const Maker& maker) {
  const Files expected = maker.make(maker.options("a"));
  for (const int threads : {1, 5}) {
    GenerateOptions options = maker.options("threads" + std::to_string(threads));
    options.threads = threads;
    CHECK(maker.make(options) == expected);
  }
  CHECK(maker.make(maker.options_again("again")) == expected);

  GenerateOptions parts = maker.options("parts");
  parts.sequences = {0, 4};
  static_cast<void>(generate(parts));
  parts.sequences.reset();
  CHECK(maker.make(parts) == expected);

  GenerateOptions shards = maker.options("shards");
  for (std::uint32_t k = 0; k < 3; ++k) {
    shards.shard = Shard{k, 3};
    const Status made = generate(shards);
    CHECK((made.ok() || (maker.some_fail && made.error().kind == ErrorKind::incomplete)));
  }
  shards.shard.reset();
  maker.check_end(finalize_dataset(shards));
  CHECK(files_of(shards.output) == expected);
}

// Up to five balls where three or four find room: too many in some of the sequences.
inline constexpr const char* kCrowded = R"(ensonify: 1
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
    place: {on: floor, area_m: [[1.2, -0.5], [2.2, 0.5]], clearance_m: 0.1}
  - {name: post, class: post, material: m, shape: {cylinder: {radius_m: 0.05, height_m: 0.5}}, pose: {position_m: [2.8, 0, -0.4]}}
trajectory: {pings: 1}
output: {cartesian: {height_px: 60}}
)";

struct CrowdedMaker : Maker {
  explicit CrowdedMaker(const std::string& on_failure, const std::string& more = "") {
    std::string text = kCrowded + more;
    text.insert(text.find("clearance_m"), "on_failure: " + on_failure + ", ");
    scenario = folder.write("crowded.yaml", text);
    some_fail = on_failure == "skip_sequence";
  }
};

}  // namespace ensonify::test
