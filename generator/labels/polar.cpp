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

struct Share {
  std::uint32_t instance;
  double energy;
};

// What the echoes of one pixel amount to.
struct PixelLabel {
  std::uint32_t instance = 0;
  double fraction = 0, elevation_rad = kNaN, elevation_std_rad = kNaN;
};

PixelLabel label_of(std::span<const Scatterer> echoes, std::vector<Share>& shares) {
  shares.clear();
  double energy = 0, first_moment = 0;
  for (const Scatterer& s : echoes) {
    const double e = expected_energy(s);
    energy += e;
    first_moment += e * s.arrival.elevation_rad;
    const auto same = std::find_if(shares.begin(), shares.end(),
                                   [&](const Share& x) { return x.instance == s.instance; });
    if (same != shares.end()) {
      same->energy += e;
    } else {
      shares.push_back({s.instance, e});
    }
  }
  PixelLabel label;
  if (!(energy > 0)) return label;
  const auto winner =
      std::min_element(shares.begin(), shares.end(), [](const Share& a, const Share& b) {
        return a.energy != b.energy ? a.energy > b.energy : a.instance < b.instance;
      });
  label.instance = winner->instance;
  label.fraction = winner->energy / energy;
  label.elevation_rad = first_moment / energy;
  double second_moment = 0;
  for (const Scatterer& s : echoes) {
    const double off = s.arrival.elevation_rad - label.elevation_rad;
    second_moment += expected_energy(s) * off * off;
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
  const ScattererList& list = *input.scatterers;
  const std::span<const Scatterer> all(list.items);
  const std::size_t end = list.beam_offset[beam + 1];
  std::size_t low = list.beam_offset[beam], high = low;
  std::vector<Share> shares;
  for (int n = 0; n < input.samples && low < end; ++n) {
    const auto sample_of = [&](std::size_t i) { return all[i].delay_s * input.bandwidth_hz; };
    while (high < end && sample_of(high) <= n + 1.0) ++high;
    while (low < high && sample_of(low) < n - 1.0) ++low;
    if (low == high) continue;
    const PixelLabel label = label_of(all.subspan(low, high - low), shares);
    const std::size_t at = std::size_t(n) * input.beams + beam;
    image.elevation_rad[at] = static_cast<float>(label.elevation_rad);
    image.elevation_std_rad[at] = static_cast<float>(label.elevation_std_rad);
    if (input.clean_power_pa2[std::size_t(beam) * input.samples + n] < input.noise_power_pa2) {
      continue;
    }
    image.instance[at] = static_cast<std::uint16_t>(label.instance);
    image.instance_fraction[at] = static_cast<float>(label.fraction);
    ENSONIFY_ASSERT(label.instance < input.class_of_instance.size());
    image.semantic[at] = input.class_of_instance[label.instance];
  }
}

}  // namespace

LabelledImage polar_image(const PolarInput& input, const Workers& workers) {
  const std::size_t count = std::size_t(input.beams) * input.samples;
  ENSONIFY_ASSERT(input.pressure_pa.size() == count && input.clean_power_pa2.size() == count);
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
