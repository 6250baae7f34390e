#include "run/sweep_time.h"

#include <algorithm>

#include "ping/tables.h"
#include "run/cost.h"
#include "run/disk_room.h"
#include "run/make_dataset.h"
#include "run/memory.h"
#include "run/sequence_worlds.h"
#include "run/sweep_parts.h"

namespace ensonify {
namespace {

struct MeasuredRun {
  RunTime time;
  double disk_bytes = 0;
};

std::optional<MeasuredRun> measure_run(const Sweep& sweep, const SweepRun& run,
                                       const Numerics& numerics, const SweepOptions& options) {
  const RunTime start = time_now();
  const auto scenario = scenario_of(sweep.file, run.point);
  if (!scenario) return std::nullopt;
  const auto worlds = SequenceWorlds::open(
      {sweep.file.base, {}, to_yaml(*scenario, [](const std::filesystem::path& file) {
         return file.string();
       })});
  if (!worlds) return std::nullopt;
  const Session& session = worlds->first();
  const int threads = Workers(options.threads).threads();
  const RunMemory memory =
      run_memory(session, threads, resident_memory(), count_echoes(session, worlds->first_tracer()),
                 cpu_memory(session, numerics));
  if (peak_bytes(memory) > available_memory()) return std::nullopt;
  const RunTime opened = time_now() - start;
  const auto measured = measure_pings({*worlds, numerics, threads, folder_there(options.output)});
  if (!measured) return std::nullopt;
  const auto pings = static_cast<std::uint32_t>(session.ping_times_s.size());
  return MeasuredRun{
      opened + time_of(*measured, session.scenario.sequences, pings, worlds->vary(), threads),
      disk_bytes(*measured, session)};
}

// The runs of a low, a middle and a high cost, cheapest first.
std::vector<std::size_t> typical_runs(const Sweep& sweep, std::vector<std::size_t> runs) {
  std::stable_sort(runs.begin(), runs.end(), [&](std::size_t a, std::size_t b) {
    return sweep.runs[a].cost.core_s < sweep.runs[b].cost.core_s;
  });
  std::vector<std::size_t> typical;
  for (const std::size_t sixth : {1U, 3U, 5U}) typical.push_back(runs[runs.size() * sixth / 6]);
  typical.erase(std::unique(typical.begin(), typical.end()), typical.end());
  return typical;
}

}  // namespace

std::optional<SweepTime> measured_time(const Sweep& sweep, const std::vector<std::size_t>& runs,
                                       const SweepOptions& options) {
  const auto numerics = settled_numerics(options.backend, options.simd, true);
  if (!numerics || runs.empty()) return std::nullopt;
  SweepTime sum;
  Cost estimated;
  double slower = 1;  // than estimated
  for (const std::size_t i : typical_runs(sweep, runs)) {
    const Cost& cost = sweep.runs[i].cost;
    // Two pings are made, and what all pings share.
    const double pings = static_cast<double>(std::max<std::uint64_t>(cost.pings, 2));
    if (slower * cost.core_s * 2 / pings > kMostMeasuredSeconds) continue;
    const auto measured = measure_run(sweep, sweep.runs[i], *numerics, options);
    if (!measured) continue;
    ++sum.measured;
    sum.time = sum.time + measured->time;
    sum.disk_bytes += measured->disk_bytes;
    estimated.core_s += cost.core_s;
    estimated.disk_bytes += cost.disk_bytes;
    slower = sum.time.core_s / estimated.core_s;
  }
  if (sum.measured == 0) return std::nullopt;
  Cost all;
  double longest_s = 0;
  for (const std::size_t i : runs) {
    const Cost& cost = sweep.runs[i].cost;
    all.core_s += cost.core_s;
    all.disk_bytes += cost.disk_bytes;
    longest_s = std::max(longest_s, cost.core_s);
  }
  const double core_s = slower * all.core_s;
  // The pings of several runs share the threads, but no run is faster than alone.
  const double alone_s = longest_s * sum.time.wall_s / estimated.core_s;
  const double wall_s = std::max(core_s / Workers(options.threads).threads(), alone_s);
  sum.time = {wall_s, core_s};
  sum.disk_bytes *= static_cast<double>(all.disk_bytes) / static_cast<double>(estimated.disk_bytes);
  return sum;
}

}  // namespace ensonify
