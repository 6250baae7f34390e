#include "run/memory.h"

#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <complex>
#include <fstream>
#include <string>

#include "core/camera_planes.h"
#include "core/front_planes.h"
#include "core/image_planes.h"
#include "core/moments.h"
#include "labels/cartesian.h"
#include "labels/footprints.h"
#include "ping/covisibility.h"
#include "ping/scene_files.h"
#include "ping/tables.h"
#include "run/cost.h"
#include "run/world_memory.h"
#include "synthesis/backend.h"
#include "synthesis/cuda_backend.h"
#include "trace/refracted.h"
#include "trace/tracer.h"

namespace ensonify {
namespace {

// Memory of a program before it loads anything, if it cannot be measured.
constexpr std::uint64_t kEmptyProcessBytes = 27'000'000;
// Code and tables that loading does not touch yet, of the program and of Embree, FFTW, OpenEXR and
// TBB.
constexpr std::uint64_t kLaterLibraryBytes = 21'000'000;
// In the record of each ping.
constexpr std::uint64_t kRecordBytesPerObject = 600;
// For each ray of a fan with adaptive refinement: two counts of pieces, and what its neighbors
// show.
constexpr std::uint64_t kPieceBytesPerRay = 20;
// Memory for shadow masks and sets of instances, which are made together.
constexpr std::uint64_t kShadowBytesPerPixel = 2, kAmodalBytesPerPixel = 4;
// Memory for a hit behind another one, until it becomes a label: the hit itself and a scatterer in
// three lists.
constexpr std::uint64_t kHiddenBytesPerHit = 2 * sizeof(Hit) + 3 * sizeof(Scatterer);
// A scatterer's part in labels: an Echo and its sample.
constexpr std::uint64_t kLabelBytesPerEcho = 48;

// A pixel of a LabelledImage.
std::uint64_t plane_bytes(const OutputSelection& output, ImageView view) {
  const bool has_floats = view == ImageView::polar || output.cartesian_exr;
  std::uint64_t bytes = 0;
  for (const ImagePlane& plane : kImagePlanes) {
    if (is_float_plane(plane) && !has_floats) continue;
    if (plane.wanted == nullptr || output.*plane.wanted) bytes += pixel_bytes(plane);
  }
  return bytes;
}

// A pixel of a FrontView.
std::uint64_t front_bytes() {
  std::uint64_t bytes = 0;
  const FrontView none;
  for (const FrontPlane& plane : kFrontPlanes) {
    bytes += with_plane(none, plane, [](const auto& values) { return sizeof(values[0]); });
  }
  return bytes;
}

// The image of a camera, and what its rows are made from.
std::uint64_t camera_bytes(const Scenario& scenario) {
  if (!scenario.output.selection.any_camera()) return 0;
  std::uint64_t of_pixel = 0;
  const CameraView none;
  for (const CameraPlane& plane : kCameraPlanes) {
    of_pixel += with_plane(none, plane, [](const auto& values) { return sizeof(values[0]); }) *
                static_cast<std::uint64_t>(plane.channels);
  }
  const CameraSpec& camera = *scenario.camera;
  const auto width = static_cast<std::uint64_t>(camera.width_px);
  return static_cast<std::uint64_t>(camera.height_px) * width * of_pixel +
         width * (2 * sizeof(Hit) + sizeof(Vec3) + sizeof(Rgb));
}

// Memory of one ping while it is computed, without that of the backend.
struct PingCounts : PingSize {
  EchoCounts echo;
  std::uint64_t echoes() const { return echo.surface + echo.coherent; }
};

// Echoes over elevation: those of each beam, and all of them. Those of volumes exist before.
std::uint64_t elevation_bytes(const Session& session, const PingCounts& count) {
  if (!session.scenario.output.selection.elevation) return 0;
  return (2 * count.echoes() + 3 * count.volume_elevations) * sizeof(ElevationEcho);
}

// Pings of one scene share its traced echoes, and the time series of a block are kept until they
// are added.
std::uint64_t held_bytes(const OutputSelection& output, const PingCounts& count,
                         std::uint64_t series) {
  return output.statistics ? kMomentBlock * series
                           : (count.echoes() + count.echo.hidden) * sizeof(Scatterer);
}

// Levels of a detector; counts of a recorder, and without images the levels that they follow from.
std::uint64_t recorded_pixel_bytes(const Scenario& scenario) {
  const std::uint64_t detected = scenario.sonar.detector ? sizeof(float) : 0;
  if (!scenario.sonar.recorder) return detected;
  const bool has_levels = detected > 0 || has_pictures(scenario.output.selection);
  const std::uint64_t levels = has_levels ? 0 : sizeof(float);
  return detected + levels + scenario.sonar.recorder->recorder.bits / 8;
}

// From rays to scatterers on surfaces. With adaptive refinement the rays through pieces of cells
// are kept meanwhile, and several threads fill one part of the list each, which is copied once.
std::uint64_t surface_bytes(const Session& session, const PingCounts& count, bool shares_threads) {
  // Scatterers that are fixed on surfaces are in two more lists before they are sorted.
  if (session.surface_tiles) return 2 * count.echo.surface * sizeof(Scatterer);
  std::uint64_t bytes = shares_threads ? count.echo.surface * sizeof(Scatterer) : 0;
  if (session.sonar.rays_per_cell == 0) return bytes;
  const std::uint64_t of_pieces = count.echo.surface - std::min(count.echo.surface, count.rays);
  return bytes + count.rays * kPieceBytesPerRay + of_pieces * sizeof(Hit);
}

// `shares_threads`: several threads make one ping.
std::uint64_t ping_bytes(const Session& session, const PingCounts& count,
                         std::uint64_t encoded_bytes, bool shares_threads) {
  const OutputSelection& output = session.scenario.output.selection;
  const bool pictures = has_pictures(output);
  const std::uint64_t grey = output.png ? count.pixels + count.cartesian_pixels : 0;
  const std::uint64_t series = count.pixels * sizeof(std::complex<float>);
  const std::uint64_t clean = pictures ? count.pixels * sizeof(float) : 0;
  const std::uint64_t volumes = session.world.volumes.size() * count.pixels * 3 * sizeof(float);
  const bool hidden = wants_hidden(output);
  const std::uint64_t unused_shadow = output.shadow ? 0 : kShadowBytesPerPixel;
  const std::uint64_t polar_pixel =
      plane_bytes(output, ImageView::polar) + (hidden ? unused_shadow + kAmodalBytesPerPixel : 0);
  const std::uint64_t cartesian_pixel =
      plane_bytes(output, ImageView::cartesian) + (output.amodal ? kAmodalBytesPerPixel : 0);
  const std::uint64_t polar = pictures ? count.pixels * polar_pixel : 0;
  // The stored levels, and their intensities.
  const int planes_shown = needs_footprints(session.scenario.output) ? 2 : 1;
  const std::uint64_t shown = output.png ? planes_shown * count.pixels * sizeof(float) : 0;
  const std::uint64_t cartesian = count.cartesian_pixels * cartesian_pixel + grey;
  const std::uint64_t labels =
      pictures ? (count.echoes() + count.echo.hidden) * kLabelBytesPerEcho : 0;

  const std::uint64_t channels = count.channel_samples * sizeof(std::complex<float>);
  // Channels and views over elevation, like layers, are kept until the files are written.
  const std::uint64_t views = (output.front ? count.rays * front_bytes() : 0) +
                              elevation_bytes(session, count) + camera_bytes(session.scenario);
  const std::uint64_t layers = count.layers * series + channels + views +
                               count.pixels * recorded_pixel_bytes(session.scenario);
  // The scatterers of one layer at a time are kept in addition to the list of all.
  const std::uint64_t layering = count.layers > 0 ? count.echoes() * sizeof(Scatterer) : 0;

  // There are three stages: rays become scatterers, of which specular ones are in three lists
  // before they are merged with the others; time series and images; files.
  const std::uint64_t merging =
      count.echo.coherent == 0 ? 0 : (count.echoes() + 2 * count.echo.coherent) * sizeof(Scatterer);
  const std::uint64_t behind =
      hidden ? count.rays * sizeof(std::uint32_t) + count.echo.hidden * kHiddenBytesPerHit : 0;
  // Moving scatterers are in blocks, in one list and in a sorted one.
  const std::uint64_t moving =
      moves(session) ? 3 * std::max(count.echoes(), count.echo.hidden) * sizeof(Scatterer) : 0;
  const bool bent = bends(session.water);
  const std::uint64_t paths = bent ? count.rays * sizeof(RayPath) : 0;
  const std::uint64_t paths_behind =
      bent && hidden ? 2 * count.echo.hidden * sizeof(RefractedHit) : 0;
  const std::uint64_t tracing = count.rays * sizeof(Hit) + paths + volumes + views +
                                std::max({merging, behind + paths_behind, moving,
                                          surface_bytes(session, count, shares_threads)});
  const std::uint64_t picturing =
      layers + volumes + series + clean + polar + std::max(cartesian + shown, labels);
  const std::uint64_t encoding = layers + (output.any_timeseries() ? series : 0) +
                                 (output.polar ? polar : 0) + cartesian + encoded_bytes;
  return held_bytes(output, count, series) +
         std::max({output.statistics ? 0 : tracing, volumes + series + clean + layers + layering,
                   picturing, encoding}) +
         (output.scatterers ? count.echoes() * sizeof(std::complex<float>) : 0) +
         session.world.objects.size() * kRecordBytesPerObject;
}

// beam_power.npy and its encoded copy.
std::uint64_t spread_bytes(const Session& session) {
  if (!session.scenario.output.selection.elevation || session.sonar.array) return 0;
  const auto beams = static_cast<std::uint64_t>(session.sonar.beam_count);
  return 2 * beams * beams * sizeof(float);
}

// Memory that all pings of one scene share: echoes, which are traced once, their moments, which are
// written array by array, and the pool.
std::uint64_t ensemble_bytes(const Session& session, const PingCounts& count) {
  if (!session.scenario.output.selection.statistics) return 0;
  const std::uint64_t volumes = session.world.volumes.size() * count.pixels * 3 * sizeof(float);
  return 3 * (count.echoes() + count.echo.hidden) * sizeof(Scatterer) + volumes +
         count.volume_elevations * sizeof(ElevationEcho) + count.rays * sizeof(Hit) +
         count.pixels * (kMoments + 4) * sizeof(double);
}

// cartesian_map, and the Footprints of labels/footprints.h with their gains.
std::uint64_t map_bytes(const Session& session, std::uint64_t pixels) {
  const std::uint64_t map = pixels * sizeof(std::int32_t);
  if (!needs_footprints(session.scenario.output)) return map;
  const Sonar& sonar = session.sonar;
  const int height_px = session.scenario.output.cartesian_height_px;
  const double samples_per_px =
      cartesian_grid(sonar, height_px).m_per_px / range_step_m(sonar, session.water);
  const auto taps =
      static_cast<std::uint64_t>(footprint_taps(samples_per_px, session.record.samples));
  // Pixels within this many pixels of the sonar are wider than a beam.
  const double near_px = std::min<double>(1 / sonar.beam_spacing_rad, height_px);
  const auto beams_of_wide = static_cast<std::uint64_t>(sonar.beam_count * near_px);
  const std::uint64_t wide = std::min(pixels, beams_of_wide);
  return map +
         pixels * (2 * sizeof(std::int32_t) + (1 + taps) * sizeof(std::uint16_t) + sizeof(float)) +
         wide * (3 * sizeof(std::int32_t) + taps * sizeof(float)) +
         (beams_of_wide + 2 * wide) * sizeof(float);
}

// How many pings a backend may make at once, at most: a block of realizations.
std::uint64_t pings_at_once(const Session& session) {
  const OutputSelection& output = session.scenario.output.selection;
  return output.statistics && !output.pings ? kMomentBlock : 1;
}

RunMemory::Count under_way(const Session& session, int threads) {
  const std::uint64_t all = std::max(threads, 1),
                      pings = work_items(static_cast<std::uint32_t>(session.ping_times_s.size()),
                                         session.scenario.output.selection);
  RunMemory::Count run;
  const bool vary = varies_by_sequence(session.scenario);
  run.sequences =
      sequences_under_way(static_cast<int>(all), pings, session.scenario.sequences, vary);
  // The first world is kept in addition to those of the sequences in progress.
  run.worlds = vary ? run.sequences : 0;
  const std::uint64_t threads_each = std::max<std::uint64_t>(1, all / run.sequences);
  const std::uint64_t pings_each = pings_under_way(static_cast<int>(threads_each), pings);
  run.computing = std::min(all, run.sequences * pings_each);
  run.waiting = run.sequences * pings_each - run.computing;
  run.scratches = run.sequences * std::min(pings_each, run.computing);
  run.workers = run.sequences * std::min(std::max(pings_each, threads_each), all);
  return run;
}

std::uint64_t all_bytes(const RunMemory& run, const RunMemory::Count& count) {
  return count.sequences * run.sequence_bytes + count.worlds * run.world_bytes +
         count.computing * run.ping_bytes + count.waiting * run.waiting_bytes +
         count.scratches * run.scratch_bytes + count.workers * run.thread_bytes;
}

// Allows for gaps in the heap and for items too small to be counted, since a process that requests
// this much memory from a cluster must not exceed it.
std::uint64_t with_reserve(std::uint64_t bytes) { return bytes + bytes / 10; }

}  // namespace

ResidentMemory resident_memory() {
  // Frees the memory that loading no longer needs, so that it does not count.
  malloc_trim(0);
  ResidentMemory memory{kEmptyProcessBytes, kEmptyProcessBytes};
  rusage children{};
  if (getrusage(RUSAGE_CHILDREN, &children) == 0) {
    memory.import_bytes = static_cast<std::uint64_t>(children.ru_maxrss) * 1024;
  }
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key; status.ignore(1 << 10, '\n')) {
    if (std::uint64_t kib = 0; (key == "VmHWM:" || key == "VmRSS:") && status >> kib) {
      (key == "VmRSS:" ? memory.now_bytes : memory.peak_bytes) = kib * 1024;
    }
  }
  return memory;
}

SynthesisMemory cpu_memory(const Session& session, const Numerics& numerics) {
  const bool has_volumes = !session.world.volumes.empty();
  // The pings that are measured need the same tables.
  if (numerics.backend == BackendChoice::cpu) {
    return pipeline_tables(session, numerics)->backend->memory(has_volumes);
  }
  const DopplerRange doppler = doppler_range(session);
  SynthesisMemory memory = make_backend({}, {session.sonar, session.water, session.record,
                                             session.scenario.synthesis_tolerance,
                                             best_simd_level(), doppler.lowest, doppler.highest})
                               ->memory(has_volumes);
  const OutputSelection& output = session.scenario.output.selection;
  if (numerics.backend == BackendChoice::cuda && output.statistics && !output.pings) {
    memory.shared_bytes += kEnsembleHostBytes;
  }
  return memory;
}

RunMemory run_memory(const Session& session, int threads, const ResidentMemory& loaded,
                     const EchoCounts& echoes, const SynthesisMemory& synthesis) {
  const PingCounts count{ping_size(session), echoes};
  const OutputSelection& output = session.scenario.output.selection;
  const std::uint64_t encoded = encoded_bytes(session, count.echoes());
  // The weights of correlated noise are a matrix if beams are unequal, as BeamMixer keeps them.
  const std::uint64_t beams = session.sonar.beam_count;
  const std::uint64_t noise_bytes =
      session.scenario.noise_correlated && !has_equal_beams(session.sonar)
          ? 2 * beams * beams * sizeof(double)
          : 0;
  const std::uint64_t bands = session.sonar.detector ? session.sonar.detector->bands : 1;
  const std::uint64_t tables =
      synthesis.shared_bytes + noise_bytes + map_bytes(session, count.cartesian_pixels);
  const std::uint64_t tile_bytes =
      session.surface_tiles ? session.surface_tiles->tiles.size() * sizeof(SurfaceTile) : 0;
  const std::uint64_t block =
      output.statistics ? kMomentBlock * count.pixels * sizeof(std::complex<float>) : 0;
  RunMemory run;
  run.count = under_way(session, threads);
  run.sequence_bytes = tables + ensemble_bytes(session, count);
  run.file_bytes = spread_bytes(session) +
                   static_cast<std::uint64_t>(scene_file_sizes(session).memory_bytes) +
                   covisibility_bytes(output, session.ping_times_s.size());
  run.world_bytes = unshared_bytes(session.world) + hierarchy_bytes(session.world) + tile_bytes;
  const bool shares_threads = static_cast<std::uint64_t>(threads) > run.count.computing;
  run.ping_bytes = ping_bytes(session, count, encoded, shares_threads);
  run.waiting_bytes = encoded + block;
  const std::uint64_t at_once = pings_at_once(session);
  const std::uint64_t band_bytes = (bands - 1) * count.pixels * sizeof(std::complex<float>);
  run.scratch_bytes =
      at_once * (synthesis.ping_bytes + band_bytes + count.echoes() * synthesis.echo_bytes);
  run.thread_bytes = at_once * synthesis.thread_bytes;
  // One of several runs holds its hierarchies as well, which are part of a loaded process.
  const bool several = loaded.now_bytes == 0;
  run.loaded_bytes = loaded.now_bytes + kLaterLibraryBytes +
                     (several && run.count.worlds == 0 ? hierarchy_bytes(session.world) : 0);
  // All sequences load at the same time.
  const std::uint64_t loading = loaded.peak_bytes - std::min(loaded.now_bytes, loaded.peak_bytes);
  run.loading_peak_bytes =
      std::max({loaded.peak_bytes, loaded.import_bytes,
                loaded.now_bytes + run.count.worlds * (run.world_bytes + loading)});
  return run;
}

std::uint64_t added_bytes(const RunMemory& run) {
  return all_bytes(run, run.count) + run.count.sequences * run.file_bytes;
}

namespace {

std::uint64_t making_bytes(const RunMemory& run) { return run.loaded_bytes + added_bytes(run); }

}  // namespace

std::uint64_t peak_bytes(const RunMemory& run) {
  return with_reserve(std::max(run.loading_peak_bytes, making_bytes(run)));
}

std::uint64_t peak_bytes(const RunMemory& run, RunMemory::Count measured,
                         const ResidentMemory& resident) {
  // More pings and worlds are counted generously, and need no reserve.
  const auto with_rest = [&](const RunMemory::Count& seen) {
    const std::uint64_t all = all_bytes(run, run.count);
    return with_reserve(resident.peak_bytes + run.count.sequences * run.file_bytes) + all -
           std::min(all, all_bytes(run, seen));
  };
  // Pings that were made side by side may have held their most at the same time or not.
  const std::uint64_t least = with_rest(measured);
  measured.computing = 1;
  // What files of a sequence take is estimated, and the measurement says nothing of it.
  const std::uint64_t making = run.file_bytes > 0
                                   ? std::max(with_reserve(making_bytes(run)), least)
                                   : std::clamp(making_bytes(run), least, with_rest(measured));
  return std::max(with_reserve(std::max(run.loading_peak_bytes, resident.import_bytes)), making);
}

}  // namespace ensonify
