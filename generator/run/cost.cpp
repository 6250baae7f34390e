#include "run/cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/moments.h"
#include "core/random.h"
#include "dataset/catalogue.h"
#include "dataset/echo_arrays.h"
#include "labels/cartesian.h"
#include "ping/prepare_session.h"
#include "ping/scene_files.h"
#include "ping/sequence_info.h"
#include "trace/adaptive.h"
#include "trace/edges.h"
#include "trace/refracted.h"
#include "trace/tracer.h"

namespace ensonify {

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

namespace {

SequenceInfo whole_sequence(const Session& session) {
  return sequence_info(session, 0, 0, static_cast<std::uint32_t>(session.ping_times_s.size()));
}

std::uint64_t most_volume_elevations(const Session& session) {
  const OutputSelection& output = session.scenario.output.selection;
  if (!output.elevation || !output.elevation_volumes) return 0;
  const double steps = std::ceil(session.sonar.elevation_fan_rad / output.elevation_step_rad) + 1;
  const double rows = std::min(steps, double(session.sonar.rays_elevation));
  return session.scenario.volumes.size() * session.sonar.beam_count * session.record.samples *
         static_cast<std::uint64_t>(rows);
}

}  // namespace

PingSize ping_size(const Session& session) {
  const Sonar& sonar = session.sonar;
  const OutputSelection& output = session.scenario.output.selection;
  PingSize size;
  size.rays = std::uint64_t(sonar.beam_count) * sonar.rays_azimuth * sonar.rays_elevation;
  size.pixels = std::uint64_t(sonar.beam_count) * session.record.samples;
  if (output.cartesian) {
    const CartesianGrid grid = cartesian_grid(sonar, session.scenario.output.cartesian_height_px);
    size.cartesian_pixels = std::uint64_t(grid.height_px) * grid.width_px;
  }
  if (output.layers) size.layers = whole_sequence(session).layers.size();
  if (output.channels) {
    size.channel_samples = std::uint64_t(sonar.array->elements) * session.record.samples;
  }
  size.volume_elevations = most_volume_elevations(session);
  return size;
}

namespace {

// A session's echoes, ping by ping. The session and the tracer must outlive it.
struct EchoCounter {
  const Session& session;
  const Tracer& tracer;
  Workers workers = Workers();
  Fan fan = make_fan(session.sonar);
  SurfaceScattering scattering =
      make_surface_scattering(session.sonar, session.water, session.world);

  EchoCounts at(std::uint32_t ping) const {
    const Tracer moment = tracer.at(object_poses(session, ping));
    return count_echoes({session, fan, scattering, moment, ping, sonar_pose(session, ping),
                         wants_hidden(session.scenario.output.selection),
                         stream_key(session.scenario.seed, Stream::speckle, 0)},
                        workers);
  }

  // How many pieces the rays that meet something at ping 0 are cut into at first.
  std::uint64_t pieces() const {
    const Tracer moment = tracer.at(object_poses(session, 0));
    const Pose sonar = sonar_pose(session, 0);
    const FanHits met = trace_fan(moment, fan, sonar, session.sonar, session.water, workers);
    const std::vector<std::uint16_t> of_ray =
        adaptive_pieces(scattering, session.cell, {fan, met.hits, sonar}, workers);
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < of_ray.size(); ++i) {
      if (met.hits[i].instance != 0) sum += of_ray[i];
    }
    return sum;
  }
};

}  // namespace

EchoCounts count_echoes(const Session& session, const Tracer& tracer) {
  const EchoCounter counter{session, tracer};
  EchoCounts most;
  for (const std::uint32_t ping : distinct_pings(session)) {
    const EchoCounts count = counter.at(ping);
    most.surface = std::max(most.surface, count.surface);
    most.coherent = std::max(most.coherent, count.coherent);
    most.hidden = std::max(most.hidden, count.hidden);
  }
  return most;
}

namespace {

// The number of scatterers of one ray's echo through walls. Each one is a tap of the walls'
// response.
constexpr std::uint64_t kWallEchoes = 16;

struct LineEchoes {
  std::uint64_t edges = 0, elastic = 0;
};

// Twice as many as at the first ping, since the sonar may come nearer.
LineEchoes line_echoes(const Session& session) {
  const Pose body = pose_at(session.path, session.ping_times_s.front());
  const Vec3 eye = compose(body, session.mount).position_m;
  const auto pieces = [&](const Line& line) -> std::uint64_t {
    const auto near = within_range(line, eye, session.sonar.range_max_m);
    return near ? pieces_of(*near, eye, session.sonar, session.water) : 0;
  };
  LineEchoes count;
  const double wavelength = session.water.sound_speed_m_s / session.sonar.frequency_hz;
  for (const BodyEdges& edged : diffracting_edges(session.world, wavelength)) {
    const Pose pose = object_pose(session.world.objects[edged.object], session.ping_times_s[0]);
    for (const Edge& edge : edged.edges) {
      count.edges += 2 * pieces({transform_point(pose, edge.line.middle_m),
                                 rotate(pose.rotation, edge.line.half_m)});
    }
  }
  for (const WorldObject& object : session.world.objects) {
    if (object.ringing.taps.empty()) continue;
    const Pose pose = object_pose(object, session.ping_times_s[0]);
    const auto* cylinder = std::get_if<CylinderShape>(&object.shape);
    const Vec3 half{0, 0, cylinder != nullptr ? cylinder->half_height_m : 0};
    count.elastic +=
        2 * object.ringing.taps.size() * pieces({pose.position_m, rotate(pose.rotation, half)});
  }
  return count;
}

}  // namespace

EchoCounts most_echoes(const Session& session) {
  const std::uint64_t rays = ping_size(session).rays;
  EchoCounts most;
  most.surface = session.sonar.rays_per_cell != 0 ? rays * kMostPieces : rays;
  if (session.surface_tiles) most.surface = most_surface_points(session);
  // Each ray continues from each specular reflector, and the sonar hears it in both directions at
  // each surface.
  const std::uint64_t bounces = session.scenario.bounces;
  most.coherent = rays * (1 + session.bounces.paths.size() + bounces * (bounces + 2));
  if (has_walls(session.scenario)) most.coherent += rays * kWallEchoes * (1 + bounces);
  const LineEchoes lines = line_echoes(session);
  most.coherent += lines.edges + lines.elastic;
  for (const School& school : session.world.schools) most.coherent += school.fish_m.size();
  if (wants_hidden(session.scenario.output.selection)) {
    most.hidden = rays * (kMostLayers - 1) + lines.elastic;
  }
  return most;
}

namespace {

// Rays that are traced in milliseconds, and in a fraction of a second: far rays at small grazing
// angles, which are cut most, are few. And the fewest of a beam that show where surfaces are.
constexpr int kFewRays = 1 << 14, kManyRays = 1 << 20, kFewRaysOfBeam = 8;
// Pieces in which a part of a cell meets nothing, and those that edges and curved surfaces add.
constexpr double kLeastPieces = 0.9, kLikelyPieces = 1.4;

Session with_rays(const Session& session, int rays, int part = 1) {
  Session few = session;
  Sonar& sonar = few.sonar;
  const int rows = std::max(rays / sonar.beam_count, kFewRaysOfBeam);
  if (sonar.rays_azimuth * sonar.rays_elevation > rows) {
    sonar.rays_azimuth = 1;
    sonar.rays_elevation = std::min(sonar.rays_elevation, rows);
  }
  sonar.rays_elevation = std::max(1, sonar.rays_elevation / part);
  few.surface_tiles.reset();
  return few;
}

// By two numbers of rays, since echoes of edges, points and fish do not grow with them.
EchoCounts without_refinement(const Session& session, const Tracer& tracer) {
  Session few = with_rays(session, kFewRays), fewer = with_rays(session, kFewRays, 2);
  few.sonar.rays_per_cell = fewer.sonar.rays_per_cell = 0;
  const EchoCounts count = EchoCounter{few, tracer}.at(0);
  const double rays = static_cast<double>(ping_size(few).rays);
  const double rest = static_cast<double>(ping_size(session).rays) - rays;
  const double apart = rays - static_cast<double>(ping_size(fewer).rays);
  if (rest <= 0 || apart <= 0) return count;
  const EchoCounts half = EchoCounter{fewer, tracer}.at(0);
  const auto all_rays = [&](std::uint64_t here, std::uint64_t there) {
    const double grown = static_cast<double>(here - std::min(here, there));
    return here + static_cast<std::uint64_t>(grown / apart * rest);
  };
  return {all_rays(count.surface, half.surface), all_rays(count.coherent, half.coherent),
          all_rays(count.hidden, half.hidden)};
}

}  // namespace

EchoProbe probe_echoes(const Session& session, const Tracer& tracer) {
  EchoProbe probe{without_refinement(session, tracer)};
  if (session.surface_tiles) {
    probe.counts.surface = 0;
    probe.likely_pieces = most_surface_points(session);
  } else if (session.sonar.rays_per_cell != 0) {
    const Session cut = with_rays(session, kManyRays);
    const double columns = double{1} * session.sonar.rays_azimuth / cut.sonar.rays_azimuth;
    const double pieces = columns * static_cast<double>(EchoCounter{cut, tracer}.pieces());
    probe.least_pieces = static_cast<std::uint64_t>(kLeastPieces * pieces);
    probe.likely_pieces = static_cast<std::uint64_t>(kLikelyPieces * pieces);
  }
  return probe;
}

namespace {

struct PerPing {
  std::uint64_t files = 0;
  double bytes = 0;
};

PerPing per_ping(const SequenceInfo& info, const PingSize& size, std::uint64_t echoes) {
  const FileSelection selection = selection_of(info);
  const GridSizes sizes = sizes_of(info);
  PerPing sum;
  for (const CatalogueRow& row : catalogue()) {
    if (row.scope != FileScope::ping || !is_wanted(row, selection)) continue;
    if (is_array(row, selection)) {
      sum.bytes += static_cast<double>(packed_bytes(row, sizes));
    } else if (is_ping_file(row, selection) || (row.shares_file && !selection.output.packed)) {
      auto cells = row.grid == FileGrid::list ? echoes : cell_count(row, sizes);
      if (row.type == kNpyElevation) cells += size.volume_elevations;
      sum.files += is_ping_file(row, selection);
      sum.bytes += row.file_bytes * static_cast<double>(cells);
    }
  }
  return sum;
}

// Seconds of one core, roughly, on the machine of docs/performance.md. A sweep compares its runs by
// them, so there are only the terms that tell its runs apart; `check` measures.
constexpr double kRunSeconds = 0.05;              // worlds, plans, manifests
constexpr double kPingSeconds = 2e-3;             // files, whatever their content
constexpr double kRaySeconds = 2.5e-7;            // trace, scatterers, speckle, sums
constexpr double kCameraRaySeconds = 8e-7;        // traced, shaded and encoded
constexpr double kSampleSeconds = 1.3e-8;         // time series and expected power
constexpr double kImagePixelSeconds = 6e-8;       // a labeled pixel, encoded
constexpr double kElementRaySeconds = 2.5e-9;     // an echo at an element
constexpr double kElementSampleSeconds = 1.2e-7;  // beams from the time series of an element
constexpr double kSurfaceRays = 4;                // scatterers fixed on surfaces, per ray
constexpr double kRaysByNeed = 2;                 // with adaptive refinement
constexpr double kSurfaceBounce = 1.5;            // rays that continue to another surface

double ping_seconds(const Session& session, const PingSize& size) {
  const OutputSelection& output = session.scenario.output.selection;
  double rays = static_cast<double>(size.rays);
  if (session.scenario.scattering.speckle == SpeckleMode::surface) rays *= kSurfaceRays;
  if (session.sonar.rays_per_cell != 0) rays *= kRaysByNeed;
  rays *= 1 + kSurfaceBounce * (session.scenario.bounces + has_walls(session.scenario));
  const double samples = static_cast<double>(size.pixels * (1 + size.layers));
  double image_pixels = static_cast<double>(size.cartesian_pixels);
  if (output.polar || output.png) image_pixels += static_cast<double>(size.pixels);
  double seconds = kPingSeconds + rays * kRaySeconds + samples * kSampleSeconds +
                   image_pixels * kImagePixelSeconds;
  if (output.any_camera()) {
    const CameraSpec& camera = *session.scenario.camera;
    const int of_pixel = 1 + (camera.samples > 1 ? camera.samples * camera.samples : 0);
    seconds += double{1} * camera.width_px * camera.height_px * of_pixel * kCameraRaySeconds;
  }
  if (const auto& array = session.sonar.array) {
    seconds += array->elements *
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

std::uint64_t encoded_bytes(const Session& session, std::uint64_t echoes) {
  const PerPing ping = per_ping(whole_sequence(session), ping_size(session), echoes);
  return static_cast<std::uint64_t>(ping.bytes);
}

double estimated_bytes(const Session& session, std::uint64_t echoes, std::uint64_t pings,
                       std::uint64_t sequences) {
  constexpr double kRecord = 8000, kManifest = 20000, kTopLevel = 20000;
  const SequenceInfo info = whole_sequence(session);
  const FileSelection selection = selection_of(info);
  const GridSizes sizes = sizes_of(info);
  double of_sequence = kManifest + scene_file_sizes(session).file_bytes;
  for (const CatalogueRow& row : catalogue()) {
    // Of statistics, maps, covisibility and beam powers.
    const bool is_large = row.grid == FileGrid::polar || row.grid == FileGrid::cartesian ||
                          row.grid == FileGrid::ping_pairs || row.grid == FileGrid::beam_pairs ||
                          row.grid == FileGrid::heights || row.grid == FileGrid::histogram ||
                          row.grid == FileGrid::lags;
    if (row.scope != FileScope::sequence || !is_large || !is_wanted(row, selection)) continue;
    of_sequence += static_cast<double>(packed_bytes(row, sizes));
  }
  const double of_ping = kRecord + per_ping(info, ping_size(session), echoes).bytes;
  return static_cast<double>(pings) * of_ping + static_cast<double>(sequences) * of_sequence +
         kTopLevel;
}

Cost estimate_cost(const Session& session, std::uint64_t echoes) {
  const std::uint64_t sequences = session.scenario.sequences;
  const SequenceInfo info = whole_sequence(session);
  const PingSize size = ping_size(session);
  const FileSelection selection = selection_of(info);
  Cost cost;
  cost.pings = sequences * session.ping_times_s.size();
  std::uint64_t once = 0, each_sequence = arrays_of(selection).size();
  for (const CatalogueRow& row : catalogue()) {
    if (!is_wanted(row, selection)) continue;
    once += row.scope == FileScope::dataset;
    each_sequence += row.scope == FileScope::sequence;
  }
  cost.files = cost.pings * per_ping(info, size, echoes).files + sequences * each_sequence + once +
               input_files(session.scenario).size();
  cost.disk_bytes =
      static_cast<std::uint64_t>(estimated_bytes(session, echoes, cost.pings, sequences));
  cost.core_s =
      three_digits(kRunSeconds + static_cast<double>(cost.pings) * ping_seconds(session, size));
  return cost;
}

Result<Cost> run_cost(Scenario scenario) {
  const Result<Session> session = prepare_without_world(std::move(scenario), 0);
  if (!session) return session.error();
  return estimate_cost(*session, ping_size(*session).rays);
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

}  // namespace ensonify
