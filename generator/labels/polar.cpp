#include "labels/polar.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/compile_targets.h"
#include "core/error.h"
#include "core/units.h"
#include "labels/sector_echoes.h"
#include "labels/transpose.h"

namespace ensonify {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr double kRoundingSlack = 1e-9;

void add_volumes(const PolarInput& input, int beam, int sample, std::vector<SectorEcho>& echoes) {
  for (const VolumeEcho& volume : input.volumes) {
    for_each_cell_beside(beam, sample, input.samples, [&](std::size_t cell, double weight) {
      const double energy = volume.energy[cell] * weight;
      if (!(energy > 0)) return;
      const double elevation = volume.elevation_rad[cell];
      const double variance = volume.elevation_square[cell] - elevation * elevation;
      echoes.push_back({0, energy, elevation, std::max(0.0, variance), volume.instance});
    });
  }
}

struct Samples {
  int first = 0, end = 0;
};

// Calls visit(sample, echoes) for each of the samples in which a beam hears an echo of its beam
// cell within c/2b.
template <class Visit>
void for_each_hearing_pixel(const PolarInput& input, int beam,
                            const std::vector<SectorEcho>& sector, const Samples& samples,
                            Visit&& visit) {
  std::vector<SectorEcho> with_volumes;
  EchoWindow window(sector, samples.first);
  for (int n = samples.first; n < samples.end; ++n) {
    std::span<const SectorEcho> heard = window.at(n);
    if (!input.volumes.empty()) {
      with_volumes.assign(heard.begin(), heard.end());
      add_volumes(input, beam, n, with_volumes);
      heard = with_volumes;
    } else if (heard.empty()) {
      n = std::max(n, window.silent_until(samples.end));
      continue;
    }
    if (!heard.empty()) visit(n, heard);
  }
}

// The label of one pixel.
struct PixelLabel {
  std::uint32_t instance = 0;
  double fraction = 0, elevation_rad = kNaN, elevation_std_rad = kNaN, energy = 0;
  std::uint32_t ghost = 0;
  std::uint32_t second = 0;
  double second_fraction = 0;
};

// Buffers that are reused from pixel to pixel.
struct Scratch {
  std::vector<EnergyShare> shares;
  std::vector<SectorEcho> direct, bounced;
};

// The instance with the most energy, and that energy.
const EnergyShare& winner_of(std::span<const SectorEcho> echoes, std::vector<EnergyShare>& shares) {
  shares.clear();
  for (const SectorEcho& echo : echoes) add_share(echo.instance, echo.energy, 0, shares);
  return strongest(shares);
}

// The instance with the most energy but for one; none if there is no other.
EnergyShare second_of(std::vector<EnergyShare>& shares, std::uint32_t winner) {
  std::erase_if(shares, [&](const EnergyShare& share) { return share.instance == winner; });
  return shares.empty() ? EnergyShare{} : strongest(shares);
}

// `echoes` holds at least one, each with energy.
PixelLabel label_of(std::span<const SectorEcho> echoes, std::vector<EnergyShare>& shares) {
  double energy = 0, first_moment = 0;
  bool alone = true;
  for (const SectorEcho& echo : echoes) {
    energy += echo.energy;
    first_moment += echo.energy * echo.elevation_rad;
    alone = alone && echo.instance == echoes[0].instance;
  }
  // Member by member: a list makes GCC clear the struct by stores that overlap its members, and the
  // reader then waits until all earlier pixels are in the cache.
  PixelLabel label;
  label.instance = echoes[0].instance;
  label.fraction = 1;
  label.elevation_rad = first_moment / energy;
  label.energy = energy;
  if (!alone) {
    const EnergyShare& winner = winner_of(echoes, shares);
    label.instance = winner.instance;
    label.fraction = winner.energy / energy;
    const EnergyShare second = second_of(shares, label.instance);
    label.second = second.instance;
    label.second_fraction = second.energy / energy;
  }
  double second_moment = 0;
  for (const SectorEcho& echo : echoes) {
    const double off = echo.elevation_rad - label.elevation_rad;
    second_moment += echo.energy * (off * off + echo.elevation_variance_rad2);
  }
  label.elevation_std_rad = std::sqrt(second_moment / energy);
  return label;
}

// The label of a pixel with bounced echoes. It is that of the direct echoes alone, and its fraction
// is the winner's share of all energy.
PixelLabel mixed_label_of(std::span<const SectorEcho> echoes, Scratch& scratch) {
  scratch.direct.clear();
  scratch.bounced.clear();
  double bounced_energy = 0;
  for (const SectorEcho& echo : echoes) {
    (echo.bounced ? scratch.bounced : scratch.direct).push_back(echo);
    if (echo.bounced) bounced_energy += echo.energy;
  }
  PixelLabel label;
  if (!scratch.direct.empty()) label = label_of(scratch.direct, scratch.shares);
  if (scratch.bounced.empty()) return label;
  const double direct_share = label.energy / (label.energy + bounced_energy);
  label.fraction *= direct_share;
  label.second_fraction *= direct_share;
  if (bounced_energy > label.energy) {
    label.ghost = winner_of(scratch.bounced, scratch.shares).instance;
  }
  return label;
}

LabelledImage blank_image(const PolarInput& input) {
  LabelledImage image;
  image.rows = input.samples;
  image.columns = input.beams;
  const std::size_t count = std::size_t(image.rows) * image.columns;
  image.level_db.resize(count);
  image.clean_db.resize(count);
  image.elevation_rad.assign(count, kNaN);
  image.elevation_std_rad.assign(count, kNaN);
  image.instance_fraction.resize(count);
  image.instance.resize(count);
  image.semantic.resize(count);
  if (input.multipath) image.multipath.resize(count);
  if (input.second) {
    image.second_instance.resize(count);
    image.second_fraction.resize(count);
  }
  return image;
}

// A block of the image that fits into the first-level cache: inputs run along samples, the image
// along beams.
constexpr int kBlockBeams = 32, kBlockSamples = 128;
struct Block {
  int first_beam = 0, beams = 0;
  Samples samples;
};

// The levels of some powers, or of the powers of some pressures.
ENSONIFY_VECTOR_CLONES void find_levels(const float* __restrict power, int count,
                                        float* __restrict level) {
  for (int i = 0; i < count; ++i) level[i] = image_level_db(power[i]);
}
ENSONIFY_VECTOR_CLONES void find_levels(const std::complex<float>* __restrict pressure, int count,
                                        float* __restrict level) {
  for (int i = 0; i < count; ++i) {
    const std::complex<float> p = pressure[i];
    level[i] = image_level_db(p.real() * p.real() + p.imag() * p.imag());
  }
}

// Writes the block of `image` [samples x beams] from `cells` [beams x samples].
template <class Cell>
void write_levels(const PolarInput& input, const Block& block, std::span<const Cell> cells,
                  std::vector<float>& image) {
  float levels[kBlockBeams][kBlockSamples];
  const int samples = block.samples.end - block.samples.first;
  for (int j = 0; j < block.beams; ++j) {
    const std::size_t from =
        std::size_t(block.first_beam + j) * input.samples + block.samples.first;
    find_levels(cells.data() + from, samples, levels[j]);
  }
  const std::size_t to = std::size_t(block.samples.first) * input.beams + block.first_beam;
  transpose(levels[0], kBlockSamples, block.beams, samples, image.data() + to, input.beams);
}

void write_labels(const PolarInput& input, int beam, const std::vector<SectorEcho>& sector,
                  const Samples& samples, Scratch& scratch, LabelledImage& image) {
  for_each_hearing_pixel(
      input, beam, sector, samples, [&](int n, std::span<const SectorEcho> echoes) {
        const bool mixed = std::ranges::any_of(echoes, &SectorEcho::bounced);
        const PixelLabel label =
            mixed ? mixed_label_of(echoes, scratch) : label_of(echoes, scratch.shares);
        const std::size_t at = std::size_t(n) * input.beams + beam;
        image.elevation_rad[at] = static_cast<float>(label.elevation_rad);
        image.elevation_std_rad[at] = static_cast<float>(label.elevation_std_rad);
        if (input.clean_power_pa2[std::size_t(beam) * input.samples + n] < input.noise_power_pa2) {
          return;
        }
        if (input.multipath) image.multipath[at] = static_cast<std::uint16_t>(label.ghost);
        if (input.second) {
          image.second_instance[at] = static_cast<std::uint16_t>(label.second);
          image.second_fraction[at] = static_cast<float>(label.second_fraction);
        }
        image.instance[at] = static_cast<std::uint16_t>(label.instance);
        image.instance_fraction[at] = static_cast<float>(label.fraction);
        ENSONIFY_ASSERT(label.instance < input.class_of_instance.size());
        image.semantic[at] = input.class_of_instance[label.instance];
      });
}

// Writes one block of beams, which fills the image's cache lines.
void write_beams(const PolarInput& input, int first_beam, LabelledImage& image) {
  Scratch scratch;
  const int beams = std::min(kBlockBeams, input.beams - first_beam);
  std::vector<SectorEcho> sectors[kBlockBeams];
  for (int j = 0; j < beams; ++j) {
    gather_sector(*input.scatterers, {}, first_beam + j, input.bandwidth_hz, sectors[j]);
  }
  for (int first = 0; first < input.samples; first += kBlockSamples) {
    const Block block{first_beam, beams, {first, std::min(first + kBlockSamples, input.samples)}};
    if (input.level_db.empty()) write_levels(input, block, input.pressure_pa, image.level_db);
    write_levels(input, block, input.clean_power_pa2, image.clean_db);
    for (int j = 0; j < beams; ++j) {
      write_labels(input, first_beam + j, sectors[j], block.samples, scratch, image);
    }
  }
}

void check_volumes(const PolarInput& input) {
  const std::size_t count = std::size_t(input.beams) * input.samples;
  for (const VolumeEcho& volume : input.volumes) {
    ENSONIFY_ASSERT(volume.energy.size() == count && volume.elevation_rad.size() == count &&
                    volume.elevation_square.size() == count);
  }
}

}  // namespace

LabelledImage polar_image(const PolarInput& input, const Workers& workers) {
  const std::size_t count = std::size_t(input.beams) * input.samples;
  ENSONIFY_ASSERT(input.clean_power_pa2.size() == count);
  ENSONIFY_ASSERT((input.level_db.empty() ? input.pressure_pa.size() : input.level_db.size()) ==
                  count);
  check_volumes(input);
  LabelledImage image = blank_image(input);
  std::ranges::copy(input.level_db, image.level_db.begin());
  const int blocks = (input.beams + kBlockBeams - 1) / kBlockBeams;
  workers.for_each(blocks, [&](std::size_t block) {
    write_beams(input, static_cast<int>(block) * kBlockBeams, image);
  });
  return image;
}

std::vector<std::uint8_t> hears_echo(const ScattererList& scatterers,
                                     std::span<const VolumeEcho> volumes, double bandwidth_hz,
                                     int beams, int samples) {
  PolarInput input;
  input.scatterers = &scatterers;
  input.volumes = volumes;
  input.bandwidth_hz = bandwidth_hz;
  input.beams = beams;
  input.samples = samples;
  check_volumes(input);
  std::vector<std::uint8_t> hears(std::size_t(beams) * samples, 0);
  std::vector<SectorEcho> sector;
  for (int beam = 0; beam < beams; ++beam) {
    gather_sector(scatterers, {}, beam, bandwidth_hz, sector);
    const std::size_t row = std::size_t(beam) * samples;
    for_each_hearing_pixel(input, beam, sector, {0, samples},
                           [&](int n, std::span<const SectorEcho>) { hears[row + n] = 1; });
  }
  return hears;
}

std::vector<float> first_return_m(const ScattererList& scatterers, int beams,
                                  double instrument_speed_m_s) {
  std::vector<float> ranges(beams, kNaN);
  for (int j = 0; j < beams; ++j) {
    double nearest = std::numeric_limits<double>::infinity(), latest_s = nearest;
    for (std::size_t i = scatterers.beam_offset[j]; i < scatterers.beam_offset[j + 1]; ++i) {
      const Scatterer& s = scatterers.items[i];
      if (s.path != 0) continue;
      // Echoes are sorted by delay, which rises with the distance except for rounding.
      if (s.delay_s > latest_s) break;
      latest_s = std::min(latest_s, s.delay_s * (1 + kRoundingSlack));
      // Without a speed these are squares; the root is taken at the end.
      const double range = instrument_speed_m_s > 0 ? instrument_speed_m_s * s.delay_s / 2
                                                    : dot(s.position_m, s.position_m);
      nearest = std::min(nearest, range);
    }
    if (!std::isfinite(nearest)) continue;
    ranges[j] = static_cast<float>(instrument_speed_m_s > 0 ? nearest : std::sqrt(nearest));
  }
  return ranges;
}

}  // namespace ensonify
