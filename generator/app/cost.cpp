#include "app/cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/ping_echoes.h"
#include "app/scene_files.h"
#include "core/moments.h"
#include "dataset/catalogue.h"
#include "dataset/echo_arrays.h"
#include "labels/cartesian.h"
#include "synthesis/beamforming.h"

namespace ensonify {
namespace {

struct PerPing {
  std::uint64_t files = 0;
  double bytes = 0;
};

FileSelection selection_of(const Session& session) {
  const OutputSelection& output = session.scenario.output.selection;
  std::vector<Layer> layers;
  if (output.layers) layers = sequence_info(session, 0, 0, 1).layers;
  const Scenario& scenario = session.scenario;
  return {output,
          std::move(layers),
          scenario.output.sdf.has_value(),
          scenario.bounces > 0 || has_walls(scenario),
          session.sonar.array.has_value(),
          0,
          false,
          scenario.output.height_map.has_value()};
}

GridSizes sizes_of(const Session& session) {
  const OutputSelection& output = session.scenario.output.selection;
  GridSizes sizes;
  sizes.beams = static_cast<std::uint64_t>(session.sonar.beam_count);
  sizes.samples = static_cast<std::uint64_t>(session.record.samples);
  sizes.elevations = static_cast<std::uint64_t>(session.sonar.rays_elevation);
  sizes.frequencies = static_cast<std::uint64_t>(session.record.transform);
  sizes.azimuths = sizes.beams * static_cast<std::uint64_t>(session.sonar.rays_azimuth);
  if (session.sonar.array) {
    sizes.elements = static_cast<std::uint64_t>(session.sonar.array->elements);
  }
  if (output.cartesian) {
    const CartesianGrid grid =
        cartesian_grid(session.sonar, session.scenario.output.cartesian_height_px);
    sizes.cartesian_height = static_cast<std::uint64_t>(grid.height_px);
    sizes.cartesian_width = static_cast<std::uint64_t>(grid.width_px);
  }
  if (session.scenario.output.height_map) {
    const HeightMap grid = height_map_grid(session);
    sizes.height_rows = static_cast<std::uint64_t>(grid.rows);
    sizes.height_columns = static_cast<std::uint64_t>(grid.columns);
  }
  return sizes;
}

}  // namespace

std::uint64_t volume_elevation_count(const Session& session) {
  const OutputSelection& output = session.scenario.output.selection;
  if (!output.elevation || !output.elevation_volumes) return 0;
  const double steps = std::ceil(session.sonar.elevation_fan_rad / output.elevation_step_rad) + 1;
  const double rows = std::min(steps, double(session.sonar.rays_elevation));
  const GridSizes sizes = sizes_of(session);
  return session.scenario.volumes.size() * sizes.beams * sizes.samples *
         static_cast<std::uint64_t>(rows);
}

namespace {

PerPing per_ping(const Session& session, std::uint64_t echoes) {
  const FileSelection selection = selection_of(session);
  const GridSizes sizes = sizes_of(session);
  PerPing sum;
  for (const CatalogueRow& row : catalogue()) {
    if (row.scope != FileScope::ping || !is_wanted(row, selection)) continue;
    if (is_array(row, selection)) {
      sum.bytes += static_cast<double>(packed_bytes(row, sizes));
    } else if (is_ping_file(row, selection) || (row.shares_file && !selection.output.packed)) {
      auto cells = row.grid == FileGrid::list ? echoes : cell_count(row, sizes);
      if (row.type == kNpyElevation) cells += volume_elevation_count(session);
      sum.files += is_ping_file(row, selection);
      sum.bytes += row.file_bytes * static_cast<double>(cells);
    }
  }
  return sum;
}

}  // namespace

PingSize ping_size(const Session& session) {
  const Sonar& sonar = session.sonar;
  PingSize size;
  size.rays = std::uint64_t(sonar.beam_count) * sonar.rays_azimuth * sonar.rays_elevation;
  size.pixels = std::uint64_t(sonar.beam_count) * session.record.samples;
  if (session.scenario.output.selection.cartesian) {
    const CartesianGrid grid = cartesian_grid(sonar, session.scenario.output.cartesian_height_px);
    size.cartesian_pixels = std::uint64_t(grid.height_px) * grid.width_px;
  }
  return size;
}

std::uint64_t layer_count(const Session& session) { return selection_of(session).layers.size(); }

std::uint64_t channel_samples(const Session& session) {
  if (!session.scenario.output.selection.channels) return 0;
  return std::uint64_t(session.sonar.array->elements) * session.record.samples;
}

int pings_under_way(int threads, std::uint64_t pings) {
  const int lanes = threads + 1 + threads / 4;
  return static_cast<int>(std::min<std::uint64_t>(lanes, pings));
}

std::uint32_t work_items(std::uint32_t pings, const OutputSelection& output) {
  return output.statistics ? (pings + kMomentBlock - 1) / kMomentBlock : pings;
}

int sequences_under_way(int threads, std::uint64_t pings, std::uint64_t sequences, bool vary) {
  const std::uint64_t wanted = pings_under_way(threads, std::uint64_t{1} << 30);
  const std::uint64_t least = vary && threads > 1 ? 2 : 1;
  return static_cast<int>(std::min(std::max((wanted + pings - 1) / pings, least), sequences));
}

Cost estimate_files(const Session& session, std::uint64_t echoes) {
  const std::uint64_t sequences = session.scenario.sequences;
  const PerPing ping = per_ping(session, echoes);

  Cost cost;
  cost.pings = sequences * session.ping_times_s.size();
  const FileSelection selection = selection_of(session);
  std::uint64_t once = 0, each_sequence = arrays_of(selection).size();
  const GridSizes sizes = sizes_of(session);
  std::uint64_t array_bytes = 0;  // of statistics, maps, covisibility and beam powers
  for (const CatalogueRow& row : catalogue()) {
    if (!is_wanted(row, selection)) continue;
    once += row.scope == FileScope::dataset;
    each_sequence += row.scope == FileScope::sequence;
    const bool is_large = row.grid == FileGrid::polar || row.grid == FileGrid::cartesian ||
                          row.grid == FileGrid::ping_pairs || row.grid == FileGrid::beam_pairs ||
                          row.grid == FileGrid::heights;
    if (row.scope == FileScope::sequence && is_large) array_bytes += packed_bytes(row, sizes);
  }
  cost.files = cost.pings * ping.files + sequences * each_sequence + once +
               input_files(session.scenario).size();
  const SceneFileSizes scene = scene_file_sizes(session);
  cost.disk_bytes = static_cast<std::uint64_t>(static_cast<double>(cost.pings) * ping.bytes) +
                    cost.pings * 8000 + sequences * 20000 + 20000 +
                    sequences * static_cast<std::uint64_t>(scene.file_bytes) +
                    sequences * array_bytes;
  return cost;
}

std::uint64_t run_peak_bytes(const Session& session, int threads, bool exact,
                             const SynthesisMemory& synthesis) {
  const EchoCounts echoes = exact ? count_echoes(session) : most_echoes(session);
  const PerPing ping = per_ping(session, echoes.surface + echoes.coherent);
  return peak_bytes(session, threads, {0, 0}, echoes, static_cast<std::uint64_t>(ping.bytes),
                    synthesis);
}

SynthesisMemory cpu_memory(const Session& session, const Numerics& numerics) {
  const bool has_volumes = !session.world.volumes.empty();
  // The pings that are measured need the same tables.
  if (numerics.backend == BackendChoice::cpu) {
    return pipeline_tables(session, numerics)->backend->memory(has_volumes);
  }
  const DopplerRange doppler = doppler_range(session);
  return make_cpu_backend({session.sonar, session.water, session.record,
                           session.scenario.synthesis_tolerance, best_simd_level(), doppler.lowest,
                           doppler.highest})
      ->memory(has_volumes);
}

Cost estimate_cost(const Session& session, int threads, const ResidentMemory& loaded,
                   const SynthesisMemory& synthesis) {
  const EchoCounts echoes = count_echoes(session);
  const std::uint64_t listed = echoes.surface + echoes.coherent;
  Cost cost = estimate_files(session, listed);
  const PerPing ping = per_ping(session, listed);
  cost.peak_bytes = peak_bytes(session, threads, loaded, echoes,
                               static_cast<std::uint64_t>(ping.bytes), synthesis);
  return cost;
}

std::string bytes_text(std::uint64_t bytes) {
  const double b = static_cast<double>(bytes);
  if (b < 1e6) return fmt::format("{:.0f} kB", b / 1e3);
  if (b < 1e7) return fmt::format("{:.1f} MB", b / 1e6);
  if (b < 1e9) return fmt::format("{:.0f} MB", b / 1e6);
  return fmt::format("{:.1f} GB", b / 1e9);
}

std::string seconds_text(double seconds) {
  if (seconds < 100) return fmt::format("{:.3g} s", seconds);
  if (seconds < 6000) return fmt::format("{:.3g} min", seconds / 60);
  return fmt::format("{:.3g} h", seconds / 3600);
}

namespace {

// Seconds of one core on the machine of docs/performance.md: times that `ensonify bench` prints for
// the cases `full` and `array`, divided by the numbers of items; kMixedBeamSeconds and
// kSightSeconds are differences of whole runs with and without.
constexpr double kRaySeconds = 2.5e-7;            // trace, scatterers, speckle, sums
constexpr double kHiddenRaySeconds = 5e-7;        // shadows, amodal masks
constexpr double kSampleSeconds = 1.3e-8;         // time series and expected power
constexpr double kPictureSeconds = 6e-8;          // a labeled pixel, encoded
constexpr double kMaskSeconds = 4e-8;             // ... without its float planes
constexpr double kElementRaySeconds = 2.5e-9;     // an echo at an element
constexpr double kElementSampleSeconds = 1.2e-7;  // beams from the time series of an element
constexpr double kMixedBeamSeconds = 1.2e-9;      // ... of unequal beams, for each other beam
constexpr double kSightSeconds = 1e-7;            // a point of covisibility in another ping
constexpr double kPingSeconds = 2e-3;             // files, whatever their content
constexpr double kRunSeconds = 0.05;              // worlds, plans, manifests
constexpr double kSurfaceRays = 4;                // scatterers fixed on surfaces, per ray
constexpr double kRaysByNeed = 2;
constexpr double kSurfaceBounce = 1.5;  // rays that continue to another surface
constexpr double kBounce = 0.25;        // multipath echoes per direct echo and bounce

double ping_seconds(const Session& session) {
  const OutputSelection& output = session.scenario.output.selection;
  const Sonar& sonar = session.sonar;
  const PingSize size = ping_size(session);
  double rays = static_cast<double>(size.rays);
  if (session.scenario.scattering.speckle == SpeckleMode::surface) rays *= kSurfaceRays;
  if (sonar.rays_per_cell > 0) rays *= kRaysByNeed;
  if (const auto& multipath = session.scenario.multipath) rays *= 1 + kBounce * multipath->bounces;
  rays *= 1 + kSurfaceBounce * (session.scenario.bounces + has_walls(session.scenario));
  const double samples = static_cast<double>(size.pixels);
  const double series = 1 + static_cast<double>(layer_count(session));
  double seconds = kPingSeconds + rays * kRaySeconds + series * samples * kSampleSeconds;
  if (output.shadow || output.amodal) seconds += rays * kHiddenRaySeconds;
  if (output.polar || output.png) seconds += samples * kPictureSeconds;
  if (output.cartesian) {
    seconds += static_cast<double>(size.cartesian_pixels) *
               (output.cartesian_exr ? kPictureSeconds : kMaskSeconds);
  }
  if (output.covisibility) {
    constexpr int kPoints = kCovisibilityColumns * kCovisibilityRows;
    seconds += kPoints * static_cast<double>(session.ping_times_s.size()) * kSightSeconds;
  }
  if (!has_equal_beams(sonar) && !sonar.array) {
    seconds += series * samples * sonar.beam_count * kMixedBeamSeconds;
  }
  if (sonar.array) {
    seconds += sonar.array->elements *
               (rays * kElementRaySeconds + session.record.samples * kElementSampleSeconds);
  }
  return seconds;
}

// Three digits are equal on all machines, whose logarithms may differ in the last bit.
double three_digits(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2);
  return std::round(value / unit) * unit;
}

}  // namespace

Result<RunCost> run_cost(Scenario scenario) {
  const Result<Session> session = prepare_without_world(std::move(scenario), 0);
  if (!session) return session.error();
  const Cost files = estimate_files(*session, ping_size(*session).rays);
  RunCost cost{files.pings, files.files, files.disk_bytes, 0};
  cost.core_s =
      three_digits(kRunSeconds + static_cast<double>(files.pings) * ping_seconds(*session));
  return cost;
}

}  // namespace ensonify
