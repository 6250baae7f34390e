// Sweep files in text, a base for them, and what reading them says.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "catch.h"
#include "results.h"
#include "sweep/expand.h"
#include "temporary_folder.h"

namespace ensonify::testing {

inline const std::string kBase =
    "ensonify: 1\n"
    "name: b\n"
    "seed: 7\n"
    "sonar: {preset: blueview_p900_90, range_max_m: 10}\n"
    "materials: {m: {reflectivity: 1e-3}}\n"
    "objects:\n"
    "  - {name: ball, material: m, shape: {sphere: {radius_m: 1}}, pose: {position_m: [4, 0, 0]}}\n"
    "trajectory: {pings: 3}\n";

// Two lines of a sweep of base.yaml; what a test adds begins in line 3.
inline const std::string kSweepHead = "ensonify_sweep: 1\nbase: base.yaml\n";

// The folder of base.yaml and s.yaml.
class SweepFolder {
 public:
  explicit SweepFolder(const std::string& base = kBase) { folder_.write("base.yaml", base); }
  const std::filesystem::path& path() const { return folder_.path(); }
  const test::TemporaryFolder& files() const { return folder_; }
  Result<SweepFile> parse(const std::string& added) const {
    return parse_sweep_file(kSweepHead + added, "s.yaml", folder_.path());
  }

 private:
  test::TemporaryFolder folder_;
};

// One ping a second of a core.
inline Result<Cost> plain_cost(const Scenario& scenario) {
  Cost cost;
  cost.pings =
      std::uint64_t(scenario.sequences) * std::uint64_t(scenario.trajectory.pings.value_or(1));
  cost.core_s = static_cast<double>(cost.pings);
  return cost;
}

inline Result<Sweep> expand(const SweepFolder& folder, const std::string& added) {
  Result<SweepFile> file = folder.parse(added);
  if (!file) return file.error();
  return expand_sweep(std::move(*file), plain_cost, Workers(2));
}

template <class T>
std::vector<std::string> faults_of(const Result<T>& result) {
  return lines_of(message_of(result));
}

inline std::vector<std::string> names_of(const Sweep& sweep) {
  std::vector<std::string> names;
  for (const SweepRun& run : sweep.runs) names.push_back(run.name);
  return names;
}

}  // namespace ensonify::testing
