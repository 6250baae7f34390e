#include "app/cost.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/memory.h"
#include "app/motion.h"
#include "core/moments.h"
#include "dataset/statistics.h"
#include "labels/cartesian.h"

namespace ensonify {
namespace {

// Bytes a pixel of a typical tank or seabed: level half uncompressed, labels ZIP, masks deflated.
constexpr double kImageFileBytesPerPixel = 2.0 + 0.9 + 0.1;
constexpr double kMaskFileBytesPerPixel = 0.02;  // and of the mask of bounced echoes
constexpr double kGreyBytesPerPixel = 0.35;
constexpr std::uint64_t kPointBytes = 3 * 8 + 6 * 4 + 2 + 1 + 2;
// Five halves, an instance and a class.
constexpr double kPackedBytesPerPixel = 5 * 2 + 2 + 1;
constexpr double kPackedShadowBytesPerPixel = 2;
// Five arrays of doubles and five of complex ones.
constexpr std::uint64_t kStatisticsBytesPerPixel = 5 * 8 + 5 * 16;
constexpr std::uint64_t kScattererRecordBytes = 8 + 4 + 12 * 4 + 4 + 2 + 24;

struct PerPing {
  std::uint64_t files = 0;
  double bytes = 0;
};

PerPing per_ping(const Session& session, std::uint64_t pixels, std::uint64_t echoes) {
  const OutputSelection& output = session.scenario.output.selection;
  PerPing sum;
  const auto add = [&](std::uint64_t files, double bytes) {
    sum.files += files;
    sum.bytes += bytes;
  };
  std::uint64_t cartesian_pixels = 0;
  if (output.cartesian) {
    const CartesianGrid grid =
        cartesian_grid(session.sonar, session.scenario.output.cartesian_height_px);
    cartesian_pixels = std::uint64_t(grid.height_px) * grid.width_px;
  }
  const std::uint64_t layers = layer_count(session);
  const double channels = 8.0 * static_cast<double>(channel_samples(session));
  const int masks = output.shadow + output.multipath;
  if (output.packed) {
    const double labels = kPackedBytesPerPixel + masks * kPackedShadowBytesPerPixel;
    const double polar = output.polar * labels + output.png + 8.0 * output.timeseries;
    const double cartesian = output.cartesian * (labels + output.png);
    add(0, (polar + 8.0 * static_cast<double>(layers)) * static_cast<double>(pixels) +
               cartesian * static_cast<double>(cartesian_pixels) + channels);
    if (output.scatterers) add(1, static_cast<double>(kScattererRecordBytes * echoes));
    if (output.points) add(1, static_cast<double>(kPointBytes * echoes));
    return sum;
  }
  if (output.timeseries) add(1, 8.0 * static_cast<double>(pixels));
  if (output.timeseries_exr) add(1, 8.0 * static_cast<double>(pixels));
  if (output.channels) add(1, channels);
  if (output.polar) add(3, kImageFileBytesPerPixel * static_cast<double>(pixels));
  if (output.cartesian) add(3, kImageFileBytesPerPixel * static_cast<double>(cartesian_pixels));
  const double mask_bytes = masks * kMaskFileBytesPerPixel;
  if (output.polar) add(masks, mask_bytes * static_cast<double>(pixels));
  if (output.cartesian) add(masks, mask_bytes * static_cast<double>(cartesian_pixels));
  if (output.png) add(1, kGreyBytesPerPixel * static_cast<double>(pixels));
  if (output.png && output.cartesian) {
    add(1, kGreyBytesPerPixel * static_cast<double>(cartesian_pixels));
  }
  add(layers, 8.0 * static_cast<double>(layers * pixels));
  if (output.scatterers) add(1, static_cast<double>(kScattererRecordBytes * echoes));
  if (output.points) add(1, static_cast<double>(kPointBytes * echoes));
  return sum;
}

std::uint64_t packed_array_count(const Session& session) {
  const OutputSelection& output = session.scenario.output.selection;
  const std::uint64_t of_image = 7 + output.shadow + output.multipath;
  if (!output.packed) return 0;
  return output.timeseries + output.channels + layer_count(session) +
         (output.polar + output.cartesian) * of_image + output.png * (1 + output.cartesian);
}

SynthesisMemory cpu_memory(const Session& session) {
  const DopplerRange doppler = doppler_range(session);
  return make_cpu_backend({session.sonar, session.water, session.record,
                           session.scenario.synthesis_tolerance, best_simd_level(), doppler.lowest,
                           doppler.highest})
      ->memory(!session.world.volumes.empty());
}

}  // namespace

std::uint64_t layer_count(const Session& session) {
  if (!session.scenario.output.selection.layers) return 0;
  return sequence_info(session, 0, 0, 1).layers.size();
}

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

int sequences_under_way(int threads, std::uint64_t pings, std::uint64_t sequences) {
  const std::uint64_t wanted = pings_under_way(threads, std::uint64_t{1} << 30);
  return static_cast<int>(std::min((wanted + pings - 1) / pings, sequences));
}

Cost estimate_files(const Session& session, std::uint64_t echoes) {
  const std::uint64_t pixels = std::uint64_t(session.sonar.beam_count) * session.record.samples;
  const std::uint64_t sequences = session.scenario.sequences;
  const PerPing ping = per_ping(session, pixels, echoes);

  Cost cost;
  cost.pings = sequences * session.ping_times_s.size();
  // A sequence: axes, poses twice, objects, boxes, first returns, annotations, sequence.json. The
  // top: card, work, manifest and its hash, scenario, index, annotations, splits, provenance.
  const std::uint64_t arrays = packed_array_count(session);
  cost.files = cost.pings * ping.files + sequences * (9 + arrays) + 11 +
               input_files(session.scenario).size();
  const SdfSize sdf = sdf_size_of(session);
  if (session.scenario.output.sdf) cost.files += sequences;
  const bool statistics = session.scenario.output.selection.statistics;
  if (statistics) cost.files += sequences * statistics_arrays().size();
  cost.disk_bytes = static_cast<std::uint64_t>(static_cast<double>(cost.pings) * ping.bytes) +
                    cost.pings * 8000 + sequences * 20000 + 20000 +
                    sequences * static_cast<std::uint64_t>(sdf.file_bytes) +
                    (statistics ? sequences * kStatisticsBytesPerPixel * pixels : 0);
  return cost;
}

std::uint64_t run_peak_bytes(const Session& session, int threads, bool exact,
                             const SynthesisMemory& synthesis) {
  const EchoCounts echoes = exact ? count_echoes(session) : most_echoes(session);
  const std::uint64_t pixels = std::uint64_t(session.sonar.beam_count) * session.record.samples;
  const PerPing ping = per_ping(session, pixels, echoes.surface + echoes.coherent);
  return peak_bytes(session, threads, {0, 0}, echoes, static_cast<std::uint64_t>(ping.bytes),
                    synthesis);
}

Cost estimate_cost(const Session& session, int threads) {
  const ResidentMemory loaded = resident_memory();
  const EchoCounts echoes = count_echoes(session);
  const std::uint64_t listed = echoes.surface + echoes.coherent;
  const std::uint64_t pixels = std::uint64_t(session.sonar.beam_count) * session.record.samples;
  Cost cost = estimate_files(session, listed);
  const PerPing ping = per_ping(session, pixels, listed);
  cost.peak_bytes = peak_bytes(session, threads, loaded, echoes,
                               static_cast<std::uint64_t>(ping.bytes), cpu_memory(session));
  return cost;
}

std::string bytes_text(std::uint64_t bytes) {
  const double b = static_cast<double>(bytes);
  if (b < 1e6) return fmt::format("{:.0f} kB", b / 1e3);
  if (b < 1e9) return fmt::format("{:.0f} MB", b / 1e6);
  return fmt::format("{:.1f} GB", b / 1e9);
}

}  // namespace ensonify
