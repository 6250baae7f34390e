// Scenarios in text and what reading them says, for the tests of this folder.
#pragma once

#include <algorithm>
#include <cctype>
#include <functional>
#include <string>
#include <vector>

#include "catch.h"
#include "results.h"
#include "scenario/scenario.h"

namespace ensonify::testing {

// Three lines that are a whole scenario; what a test adds begins in line 4.
inline const std::string kHead =
    "ensonify: 1\n"
    "name: t\n"
    "sonar: {preset: blueview_p900_90}\n";

// The example of the documentation.
inline const std::string kExample = R"(ensonify: 1                         # version of this format
name: tank_example
seed: 7
sonar: {preset: blueview_p900_90, range_max_m: 10, rays: {elevation: 114, azimuth: 1}}
water: {sound_speed_m_s: 1500, absorption: {model: francois_garrison, temperature_c: 10, salinity_psu: 35, ph: 8, depth_m: 5}}
scattering: {lambert_exponent: 1, normalization: calibrated, speckle: per_ping}
materials:
  concrete: {reflectivity: 1e-3}
  steel:    {reflectivity: 1e-2, coherent: {model: rician, k: 0.5}}
objects:
  - {name: tank, class: structure, material: concrete, shape: {box: {size_m: [11, 11, 4], inward_facing: true}}, pose: {position_m: [0, 0, 0]}}
  - {name: target, class: cylinder, material: steel, shape: {cylinder: {radius_m: 0.2, height_m: 2}}, pose: {position_m: [4, 0, 0], rotation_deg: [0, 0, 0]}}
point_targets:
  - {name: calibration, target_strength_db: -40, position_m: [3, 1, 0]}
trajectory: {poses: [{time_s: 0, position_m: [0, 0, 0], rotation_deg: [0, 0, 0]}], ping_rate_hz: 5, pings: 10}
noise: {spectrum_level_db: 30}      # dB re 1 µPa²/Hz; absent: none
output: {timeseries: npy, polar: true, cartesian: {height_px: 1000}, png: true, shadow: true, amodal: true, scatterers: false}
)";

inline Result<Scenario> parse(const std::string& text,
                              const std::vector<Override>& overrides = {}) {
  return parse_scenario(text, "t.yaml", ".", overrides);
}

inline std::string emit(const Scenario& scenario) {
  return to_yaml(scenario, [](const std::filesystem::path& file) { return file.string(); });
}

// What the resolved text says. It reads back to itself, which is checked.
inline Scenario read_again(const Scenario& scenario, const std::filesystem::path& folder = ".") {
  const std::string resolved = emit(scenario);
  INFO(resolved);
  Scenario again = value_of(parse_scenario(resolved, "again.yaml", folder));
  CHECK(emit(again) == resolved);
  return again;
}

// The faults, one a line; empty for a scenario without.
inline std::vector<std::string> faults_of(const std::string& text,
                                          const std::vector<Override>& overrides = {}) {
  return lines_of(message_of(parse(text, overrides)));
}

// Whether one of the lines begins so (place and key path) and says so further on.
inline bool tells(const std::vector<std::string>& lines, const std::string& begin,
                  const std::string& essential) {
  return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
    return line.starts_with(begin) && line.find(essential, begin.size()) != std::string::npos;
  });
}

struct FaultCase {
  std::string added;      // from line 4 on
  std::string begin;      // file:line:column: key.path:
  std::string essential;  // further on in the same line
};

inline std::string beside_head(const std::string& added) { return kHead + added; }

// Each text has the one fault and no other. `text_of` makes a scenario of what a case adds; a
// `begin` without line and column may stand at any place.
inline void check_single_faults(
    const std::vector<FaultCase>& cases,
    const std::function<std::string(const std::string&)>& text_of = beside_head) {
  for (const FaultCase& c : cases) {
    const auto lines = faults_of(text_of(c.added));
    INFO(c.added << "\n" << joined_lines(lines));
    REQUIRE(lines.size() == 1);
    if (std::isdigit(static_cast<unsigned char>(c.begin[0]))) {
      CHECK(tells(lines, "t.yaml:" + c.begin, c.essential));
    } else {
      CHECK(tells(lines, "t.yaml:", ": " + c.begin));
      CHECK(contains(lines[0], c.essential));
    }
  }
}

inline bool is_one_fault(const std::string& added, const std::string& essential) {
  const auto lines = faults_of(kHead + added);
  CAPTURE(added, lines);
  return lines.size() == 1 && contains(lines[0], essential);
}

}  // namespace ensonify::testing
