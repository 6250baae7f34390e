#include "app/bench_growth.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <variant>

#include "app/tables.h"
#include "app/timed_data_set.h"
#include "bench/machine.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

double beams_of(const Session& session) { return session.sonar.beam_count; }

double samples_of(const Session& session) { return session.record.samples; }

double rays_of(const Session& session) {
  const Sonar& sonar = session.sonar;
  return static_cast<double>(sonar.beam_count) * sonar.rays_azimuth * sonar.rays_elevation;
}

double objects_of(const Session& session) {
  return static_cast<double>(session.world.instances.size());
}

double triangles_of(const Session& session) {
  double count = 0;
  for (const WorldObject& object : session.world.objects) {
    const auto* shape = std::get_if<MeshShape>(&object.shape);
    if (shape != nullptr) count += static_cast<double>(shape->mesh->triangles.size());
  }
  return count;
}

// The objects are in view of the sonar, so that each adds echoes and labels.
Override spheres(int count) {
  return {"objects.10",  // appended
          fmt::format("{{name: stone, class: stone, count: {}, material: steel, shape: {{sphere: "
                      "{{radius_m: 0.3}}}}, pose: {{position_m: [{{uniform: [6, 55]}}, {{uniform: "
                      "[-30, 30]}}, {{uniform: [-1.5, -0.5]}}]}}}}",
                      count)};
}

// Cartesian images have a fixed size, which would hide the growth of the rest.
std::vector<Override> fixed_keys() {
  return {{"output", "{cartesian: false, png: false}"}, {"sonar.beams.count", "128"}};
}

GrowthStep step_of(int threads, std::uint32_t pings) { return {threads, pings, fixed_keys()}; }

GrowthAxis axis_of(std::string name, double (*size)(const Session&), int threads,
                   const std::vector<Override>& each) {
  GrowthAxis axis{std::move(name), size, {}};
  for (const Override& value : each) {
    axis.steps.push_back(step_of(threads, 8));
    axis.steps.back().overrides.push_back(value);
  }
  return axis;
}

GrowthAxis thread_axis(int threads) {
  GrowthAxis axis{"threads", nullptr, {}};
  const auto add = [&](int count) {
    axis.steps.push_back(step_of(count, static_cast<std::uint32_t>(std::max(8, 4 * count))));
  };
  for (int count = 1; count < threads; count *= 2) add(count);
  add(threads);
  return axis;
}

struct Step {
  DataSetPlan plan;
  SequenceWorlds worlds;
  BenchSite site;
  GrowthPoint point;
  std::vector<TimedDataSet> runs = {};
};

Result<Step> open_step(const fs::path& file, const GrowthAxis& axis, const GrowthStep& step,
                       const BenchSite& site) {
  Result<DataSetPlan> plan = plan_data_set({file, step.overrides}, step.pings);
  if (!plan) return plan.error();
  const double before_ms = core_ms();
  Result<SequenceWorlds> worlds = SequenceWorlds::open(plan->input);
  if (!worlds) return worlds.error();
  GrowthPoint point;
  point.world_core_ms = core_ms() - before_ms;
  point.value = axis.size != nullptr ? axis.size(worlds->first()) : step.threads;
  Step opened{std::move(*plan), std::move(*worlds), site, point};
  opened.site.threads = step.threads;
  return opened;
}

void settle_point(Step& step) {
  std::vector<double> rates, core;
  for (const TimedDataSet& run : step.runs) {
    rates.push_back(run.pings_per_s);
    core.push_back(run.core_ms_per_ping);
  }
  step.point.pings = step.runs.back().pings;
  step.point.pings_per_s = median(std::move(rates));
  step.point.core_ms_per_ping = median(std::move(core));
}

}  // namespace

std::vector<GrowthAxis> growth_axes(int threads) {
  const auto values = [](const char* key, const std::vector<const char*>& all) {
    std::vector<Override> each;
    for (const char* value : all) each.push_back({key, value});
    return each;
  };
  return {
      thread_axis(threads),
      axis_of("beams", beams_of, threads,
              values("sonar.beams.count", {"128", "256", "512", "1024"})),
      axis_of("samples", samples_of, threads,
              values("sonar.bandwidth_hz", {"14950", "29900", "59800", "119600"})),
      axis_of("rays", rays_of, threads,
              values("sonar.rays.elevation", {"114", "342", "1026", "3078"})),
      axis_of("objects", objects_of, threads,
              {spheres(64), spheres(256), spheres(1024), spheres(4096)}),
      axis_of("triangles", triangles_of, threads,
              values("objects.0.shape.heightfield.cell_m", {"0.62", "0.31", "0.155", "0.0775"}))};
}

Result<GrowthReport> bench_growth(const DataSetCase& base, const GrowthAxis& axis,
                                  const GrowthBenchOptions& options) {
  const Result<fs::path> file = write_case(base, options.folder);
  if (!file) return file.error();
  Result<Numerics> numerics = settle_backend(BackendChoice::cpu, best_simd_level());
  if (!numerics) return numerics.error();
  const BenchSite site{1, options.folder, std::move(*numerics)};
  std::vector<Step> steps;
  for (const GrowthStep& step : axis.steps) {
    Result<Step> opened = open_step(*file, axis, step, site);
    if (!opened) return opened.error();
    steps.push_back(std::move(*opened));
  }
  for (int i = 0; i < options.runs; ++i) {
    if (options.on_progress) {
      options.on_progress(
          fmt::format("growth with {}, run {} of {}", axis.name, i + 1, options.runs));
    }
    for (Step& step : steps) {
      Result<TimedDataSet> run = time_in_world(step.worlds, step.plan, step.site);
      if (!run) return run.error();
      step.runs.push_back(*run);
    }
  }
  GrowthReport report{axis.name, options.runs, {}};
  for (Step& step : steps) {
    settle_point(step);
    report.points.push_back(step.point);
  }
  return report;
}

}  // namespace ensonify
