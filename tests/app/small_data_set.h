// Small data sets in a folder of their own.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "catch.h"
#include "cli/commands.h"
#include "temporary_folder.h"

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

inline std::map<std::string, std::string> files_of(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::map<std::string, std::string> files;
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

  GenerateOptions options(const std::string& output) const {
    GenerateOptions o;
    o.input.scenario = scenario;
    o.input.overrides = {{"output.scatterers", "true"}};
    o.output = folder.path() / output;
    o.threads = 2;
    o.quiet = true;
    return o;
  }
  std::map<std::string, std::string> make(const GenerateOptions& o) const {
    const Status status = generate(o);
    if (!status) FAIL(status.error().message);
    if (const Status whole = verify(o.output, 2); !whole) FAIL(whole.error().message);
    return files_of(o.output);
  }
};

}  // namespace ensonify::test
