#include "synthesis/cuda/beam_tables.h"

#include <cmath>

#include "acoustics/pulse.h"
#include "core/error.h"
#include "synthesis/cuda/beam_kernels.h"
#include "synthesis/mixing.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// Single precision leaves 1e-6 anyway.
constexpr double kPowerError = 1e-6;

}  // namespace

DeviceSpread spread_of(const SpreadKernel& kernel, int transform) {
  ENSONIFY_ASSERT(kernel.points > 0);
  DeviceSpread spread;
  spread.points = kernel.points;
  spread.width = kernel.width;
  spread.degree = kernel.degree;
  const std::size_t pairs = std::size_t(kernel.polynomial().chunks) * 8;
  for (int d = 0; d <= kernel.degree; ++d) {
    for (int l = 0; l < kernel.width; ++l) {
      spread.coefficient.push_back(kernel.coefficient[d * pairs + 2 * l]);
    }
  }
  spread.filter.resize(transform);
  spread.upper_filter.resize(transform);
  spread.cell_filter.resize(transform);
  return spread;
}

DeviceSpread series_spread(const std::vector<Complex>& spectrum, double error) {
  const int bins = static_cast<int>(spectrum.size()), half = bins / 2;
  const SpreadKernel kernel = choose_spread_kernel(spectrum, -half, error);
  DeviceSpread spread = spread_of(kernel, bins);
  for (int k = -half; k < half; ++k) {
    const int bin = k < 0 ? k + bins : k;
    spread.filter[bin] = narrow(spectrum[k + half] * kernel.correction[std::abs(k)]);
    spread.cell_filter[bin] = narrow(spectrum[k + half]);
  }
  return spread;
}

namespace {

DeviceSpread power_spread(const std::vector<Complex>& autospectrum) {
  const int bins = static_cast<int>(autospectrum.size());
  const SpreadKernel kernel = choose_spread_kernel(autospectrum, 0, kPowerError);
  DeviceSpread spread = spread_of(kernel, bins);
  for (int k = 0; k < bins; ++k) {
    const Complex upper = k > 0 ? std::conj(autospectrum[bins - k]) : Complex(0);
    spread.filter[k] = narrow(autospectrum[k] * kernel.correction[k]);
    if (k > 0) spread.upper_filter[k] = narrow(upper * kernel.correction[bins - k]);
    spread.cell_filter[k] = narrow(autospectrum[k] + upper);
  }
  return spread;
}

}  // namespace

BeamTables make_beam_tables(const SynthesisSetup& setup) {
  const std::vector<Complex> spectrum = pulse_spectrum(setup.sonar, setup.record.transform);
  const Mixing mixing = make_mixing(setup.sonar);
  const int beams = setup.sonar.beam_count;
  BeamTables tables;
  tables.series = series_spread(spectrum);
  tables.power = power_spread(pulse_autospectrum(spectrum));
  tables.weight.assign(2 * kBeamsAThread + 2 * beams - 1, 0.0f);
  tables.power_weight = tables.weight;
  for (int d = 1 - beams; d < beams; ++d) {
    const double w = mixing.weight[std::abs(d)];
    tables.weight[kBeamsAThread + d + beams - 1] = static_cast<float>(w);
    tables.power_weight[kBeamsAThread + d + beams - 1] = static_cast<float>(w * w);
  }
  for (const double s : mixing.scale) {
    tables.scale.push_back(static_cast<float>(s));
    tables.power_scale.push_back(static_cast<float>(s * s));
  }
  return tables;
}

}  // namespace ensonify
