#include "labels/polar.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

double expected_energy(const Scatterer& s) {
  const double square = std::norm(std::complex<double>(s.mean)) +
                        static_cast<double>(s.standard_deviation) * s.standard_deviation;
  return square * s.gain * s.gain;
}

// One source of a pixel's energy: a scatterer, or a volume in one of its cells.
struct Echo {
  std::uint32_t instance;
  double energy, elevation_rad, elevation_variance_rad2;
};

// Echoes of the volumes in one pixel: its own cell and half of the two beside it, since a cell
// reaches c/4b and the pixel c/2b to either side.
void add_volumes(const PolarInput& input, int beam, int sample, std::vector<Echo>& echoes) {
  for (const VolumeEcho& volume : input.volumes) {
    for (int n = std::max(0, sample - 1); n <= std::min(input.samples - 1, sample + 1); ++n) {
      const std::size_t cell = std::size_t(beam) * input.samples + n;
      const double energy = volume.energy[cell] * (n == sample ? 1.0 : 0.5);
      if (!(energy > 0)) continue;
      const double elevation = volume.elevation_rad[cell];
      const double variance = volume.elevation_square[cell] - elevation * elevation;
      echoes.push_back({volume.instance, energy, elevation, std::max(0.0, variance)});
    }
  }
}

// Calls visit(sample, echoes) for every pixel of a beam that hears an echo of its own sector within
// c/2b of its sample.
template <class Visit>
void for_each_hearing_pixel(const PolarInput& input, int beam, Visit&& visit) {
  const ScattererList& list = *input.scatterers;
  const std::size_t end = list.beam_offset[beam + 1];
  std::size_t low = list.beam_offset[beam], high = low;
  std::vector<Echo> echoes;
  for (int n = 0; n < input.samples; ++n) {
    const auto sample_of = [&](std::size_t i) {
      return list.items[i].delay_s * input.bandwidth_hz;
    };
    while (high < end && sample_of(high) <= n + 1.0) ++high;
    while (low < high && sample_of(low) < n - 1.0) ++low;
    echoes.clear();
    for (std::size_t i = low; i < high; ++i) {
      const Scatterer& s = list.items[i];
      const double energy = expected_energy(s);
      if (energy > 0) echoes.push_back({s.instance, energy, s.arrival.elevation_rad, 0});
    }
    add_volumes(input, beam, n, echoes);
    if (!echoes.empty()) visit(n, echoes);
  }
}

struct Share {
  std::uint32_t instance;
  double energy;
};

// What the echoes of one pixel amount to.
struct PixelLabel {
  std::uint32_t instance = 0;
  double fraction = 0, elevation_rad = kNaN, elevation_std_rad = kNaN;
};

// `echoes` holds at least one, each with energy.
PixelLabel label_of(const std::vector<Echo>& echoes, std::vector<Share>& shares) {
  shares.clear();
  double energy = 0, first_moment = 0;
  for (const Echo& echo : echoes) {
    energy += echo.energy;
    first_moment += echo.energy * echo.elevation_rad;
    const auto same = std::find_if(shares.begin(), shares.end(),
                                   [&](const Share& x) { return x.instance == echo.instance; });
    if (same != shares.end()) {
      same->energy += echo.energy;
    } else {
      shares.push_back({echo.instance, echo.energy});
    }
  }
  const auto winner =
      std::min_element(shares.begin(), shares.end(), [](const Share& a, const Share& b) {
        return a.energy != b.energy ? a.energy > b.energy : a.instance < b.instance;
      });
  PixelLabel label;
  label.instance = winner->instance;
  label.fraction = winner->energy / energy;
  label.elevation_rad = first_moment / energy;
  double second_moment = 0;
  for (const Echo& echo : echoes) {
    const double off = echo.elevation_rad - label.elevation_rad;
    second_moment += echo.energy * (off * off + echo.elevation_variance_rad2);
  }
  label.elevation_std_rad = std::sqrt(second_moment / energy);
  return label;
}

LabelledImage blank_image(int rows, int columns) {
  LabelledImage image{rows, columns, {}, {}, {}, {}, {}, {}, {}};
  const std::size_t count = std::size_t(rows) * columns;
  image.level_db.resize(count);
  image.clean_db.resize(count);
  image.elevation_rad.assign(count, kNaN);
  image.elevation_std_rad.assign(count, kNaN);
  image.instance_fraction.assign(count, 0);
  image.instance.assign(count, 0);
  image.semantic.assign(count, 0);
  return image;
}

void label_beam(const PolarInput& input, int beam, LabelledImage& image) {
  std::vector<Share> shares;
  for_each_hearing_pixel(input, beam, [&](int n, const std::vector<Echo>& echoes) {
    const PixelLabel label = label_of(echoes, shares);
    const std::size_t at = std::size_t(n) * input.beams + beam;
    image.elevation_rad[at] = static_cast<float>(label.elevation_rad);
    image.elevation_std_rad[at] = static_cast<float>(label.elevation_std_rad);
    if (input.clean_power_pa2[std::size_t(beam) * input.samples + n] < input.noise_power_pa2) {
      return;
    }
    image.instance[at] = static_cast<std::uint16_t>(label.instance);
    image.instance_fraction[at] = static_cast<float>(label.fraction);
    ENSONIFY_ASSERT(label.instance < input.class_of_instance.size());
    image.semantic[at] = input.class_of_instance[label.instance];
  });
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
  ENSONIFY_ASSERT(input.pressure_pa.size() == count && input.clean_power_pa2.size() == count);
  check_volumes(input);
  LabelledImage image = blank_image(input.samples, input.beams);
  workers.for_each(input.beams, [&](std::size_t beam) {
    for (int n = 0; n < input.samples; ++n) {
      const std::size_t from = beam * input.samples + n;
      const std::size_t to = std::size_t(n) * input.beams + beam;
      image.level_db[to] = level_db(std::norm(std::complex<double>(input.pressure_pa[from])));
      image.clean_db[to] = level_db(input.clean_power_pa2[from]);
    }
    label_beam(input, static_cast<int>(beam), image);
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
  for (int beam = 0; beam < beams; ++beam) {
    for_each_hearing_pixel(input, beam, [&](int n, const std::vector<Echo>&) {
      hears[std::size_t(beam) * samples + n] = 1;
    });
  }
  return hears;
}

std::vector<float> first_return_m(const ScattererList& scatterers, int beams) {
  std::vector<float> ranges(beams, kNaN);
  for (int j = 0; j < beams; ++j) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = scatterers.beam_offset[j]; i < scatterers.beam_offset[j + 1]; ++i) {
      nearest = std::min(nearest, length(scatterers.items[i].position_m));
    }
    if (std::isfinite(nearest)) ranges[j] = static_cast<float>(nearest);
  }
  return ranges;
}

}  // namespace ensonify
