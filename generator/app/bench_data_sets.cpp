#include "app/bench_data_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "app/tables.h"
#include "app/timed_data_set.h"
#include "bench/machine.h"
#include "formats/files.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

// Pixels of one view share their file of labels, so expected level and elevation have no row of
// their own. Files that only some scenarios have (channels, multipath masks, the distance field of
// a sequence) have no row either.
constexpr FileKind kKinds[] = {
    {"series", "{polar: false, cartesian: false, png: false}"},
    {"series_exr", "{timeseries: both, polar: false, cartesian: false, png: false}"},
    {"polar", "{cartesian: false, png: false, shadow: false, amodal: false}"},
    {"polar_shadow", "{cartesian: false, png: false, amodal: false}"},
    {"polar_amodal", "{cartesian: false, png: false, shadow: false}"},
    {"polar_polygons",
     "{cartesian: false, png: false, shadow: false, amodal: false, polygons: true}"},
    {"polar_surfaces",
     "{cartesian: false, png: false, shadow: false, amodal: false, surfaces: true}"},
    {"polar_motion", "{cartesian: false, png: false, shadow: false, amodal: false, motion: true}"},
    {"cartesian",
     "{polar: false, cartesian: {exr: true}, png: false, shadow: false, amodal: false}"},
    {"png", "{polar: false, cartesian: false}"},
    {"scatterers", "{polar: false, cartesian: false, png: false, scatterers: true}"},
    {"points", "{polar: false, cartesian: false, png: false, points: true}"},
    {"front", "{polar: false, cartesian: false, png: false, front: true}"},
    {"elevation", "{polar: false, cartesian: false, png: false, elevation: true}"},
    {"layers", "{polar: false, cartesian: false, png: false, layers: true}"},
    {"default", "{}"},
    {"default_packed", "{one_file_per: sequence}"},
    {"every",
     "{timeseries: both, cartesian: {exr: true}, polygons: true, scatterers: true, points: true, "
     "layers: true, surfaces: true, motion: true, front: true, elevation: true}"}};

constexpr FileKind kOwn[] = {{"its own", nullptr}};

void add_stages(const std::vector<TimedDataSet>& runs, FileKindReport& report) {
  double rest_ms = report.core_ms_per_ping, physics_ms = 0;
  for (int s = 0; s < kStageCount; ++s) {
    std::vector<double> ms;
    for (const TimedDataSet& run : runs) ms.push_back(run.stages_ms[static_cast<std::size_t>(s)]);
    const auto stage = static_cast<Stage>(s);
    const double middle_ms = median(ms);
    report.stages.push_back({stage_name(stage), middle_ms});
    rest_ms -= middle_ms;
    if (is_physics(stage)) physics_ms += middle_ms;
  }
  report.stages.push_back({"rest", std::max(0.0, rest_ms)});
  report.physics_share = physics_ms / report.core_ms_per_ping;
}

FileKindReport summary_of(const FileKind& kind, const std::vector<TimedDataSet>& runs) {
  const auto all = [&](double TimedDataSet::*member) {
    std::vector<double> values;
    for (const TimedDataSet& run : runs) values.push_back(run.*member);
    return values;
  };
  const std::vector<double> rates = all(&TimedDataSet::pings_per_s);
  const auto [least, most] = std::minmax_element(rates.begin(), rates.end());
  FileKindReport report{kind.name,
                        median(rates),
                        *least,
                        *most,
                        median(all(&TimedDataSet::core_ms_per_ping)),
                        median(all(&TimedDataSet::mb_per_ping)),
                        {},
                        0};
  add_stages(runs, report);
  return report;
}

Result<TimedDataSet> time_kind(const ScenarioOptions& input, const FileKind& kind,
                               std::uint32_t pings, const BenchSite& site) {
  ScenarioOptions with_kind = input;
  if (kind.output != nullptr) with_kind.overrides.push_back({"output", kind.output});
  const Result<DataSetPlan> plan = plan_data_set(with_kind, pings);
  if (!plan) return plan.error();
  return time_data_set(*plan, site);
}

// Measures every kind once, then all of them again.
Result<DataSetReport> measure(std::string name, const ScenarioOptions& input,
                              std::span<const FileKind> kinds, const DataSetBenchOptions& options) {
  Result<Numerics> numerics = settle_backend(BackendChoice::cpu, best_simd_level());
  if (!numerics) return numerics.error();
  numerics->tables = std::make_shared<TableCache>();
  const BenchSite site{options.threads, options.folder, std::move(*numerics)};
  DataSetReport report;
  report.name = std::move(name);
  report.runs = options.runs;
  std::vector<std::vector<TimedDataSet>> runs(kinds.size());
  for (int i = 0; i < options.runs; ++i) {
    for (std::size_t k = 0; k < runs.size(); ++k) {
      if (options.on_progress) {
        options.on_progress(fmt::format("data set {}, run {} of {}: {}", report.name, i + 1,
                                        options.runs, kinds[k].name));
      }
      const Result<TimedDataSet> run = time_kind(input, kinds[k], options.pings, site);
      if (!run) return run.error();
      runs[k].push_back(*run);
      report.beams = run->beams;
      report.samples = run->samples;
      report.pings = run->pings;
    }
  }
  for (std::size_t k = 0; k < runs.size(); ++k) {
    report.kinds.push_back(summary_of(kinds[k], runs[k]));
  }
  return report;
}

}  // namespace

std::span<const FileKind> file_kinds() { return kKinds; }
std::span<const FileKind> own_files() { return kOwn; }

Result<fs::path> write_case(const DataSetCase& which, const fs::path& folder) {
  for (const BenchMesh& mesh : bench_meshes()) {
    const std::string name = fmt::format("meshes/{}.obj", mesh.name);
    if (const auto written = write_file_atomically(folder, name, mesh.text); !written) {
      return written.error();
    }
  }
  const std::string name = std::string(which.name) + ".yaml";
  const auto written = write_file_atomically(folder, name, which.text);
  if (!written) return written.error();
  return folder / name;
}

Result<DataSetReport> bench_data_set(const DataSetCase& which, std::span<const FileKind> kinds,
                                     const DataSetBenchOptions& options) {
  const Result<fs::path> file = write_case(which, options.folder);
  if (!file) return file.error();
  return measure(which.name, {*file, {}}, kinds, options);
}

Result<DataSetReport> bench_scenario(const ScenarioOptions& input,
                                     const DataSetBenchOptions& options) {
  return measure(input.scenario.stem().string(), input, kOwn, options);
}

}  // namespace ensonify
