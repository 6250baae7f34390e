#include "instrument/beam_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "synthesis/beamforming.h"
#include "synthesis/draw.h"

namespace ensonify {
namespace {

Mixing noise_mixing(Sonar sonar) {
  sonar.transmit.reset();  // noise arrives whatever is sent
  sonar.normalization =
      has_equal_beams(sonar) ? Normalization::mean_square : Normalization::calibrated;
  Mixing mixing = make_mixing(sonar);
  for (int j = 0; j < sonar.beam_count && !mixing.is_equal(); ++j) {
    double energy = 0;
    for (int i = 0; i < sonar.beam_count; ++i) {
      double& w = mixing.matrix[std::size_t(j) * sonar.beam_count + i];
      w *= std::sqrt(cell_width_rad(sonar, i) / sonar.beam_spacing_rad);
      energy += w * w;
    }
    mixing.scale[j] = 1 / std::sqrt(energy);
  }
  return mixing;
}

}  // namespace

BeamNoise::BeamNoise(const Sonar& sonar) : beams_(sonar.beam_count), mixer_(noise_mixing(sonar)) {}

void BeamNoise::add(std::uint64_t key, std::uint32_t ping, double power_pa2, int samples,
                    std::span<std::complex<float>> pressure_pa, const Workers& workers) const {
  ENSONIFY_ASSERT(pressure_pa.size() == static_cast<std::size_t>(beams_) * samples);
  constexpr int kColumns = 128;
  const double rms = std::sqrt(power_pa2);
  std::vector<std::complex<double>> rows(static_cast<std::size_t>(beams_) * kColumns);
  for (int first = 0; first < samples; first += kColumns) {
    const int columns = std::min(kColumns, samples - first);
    const auto row_of = [&](std::size_t beam) { return rows.data() + beam * kColumns; };
    workers.for_each(beams_, [&](std::size_t beam) {
      for (int k = 0; k < columns; ++k) {
        const ComplexDraw n = cell_draw(key, ping, static_cast<std::int64_t>(beam), first + k, rms);
        row_of(beam)[k] = {n.re, n.im};
      }
    });
    mixer_.mix_amplitude(rows.data(), columns, kColumns, workers);
    workers.for_each(beams_, [&](std::size_t beam) {
      std::complex<float>* out = pressure_pa.data() + beam * samples + first;
      for (int k = 0; k < columns; ++k) out[k] += std::complex<float>(row_of(beam)[k]);
    });
  }
}

}  // namespace ensonify
