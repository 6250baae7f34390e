#include "bench/exact.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "acoustics/propagation.h"
#include "acoustics/pulse.h"
#include "bench/fft_rows.h"
#include "core/units.h"
#include "synthesis/mixing.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr int kTenths = 10;
constexpr double kFaintTenth = 1e-6;
// Samples of all beams that fit into a cache together.
constexpr int kMixColumns = 64;

struct DoublePhasors {
  explicit DoublePhasors(std::size_t count, int bins)
      : start_re(count),
        start_im(count),
        step_re(count),
        step_im(count),
        re(padded_bins(bins)),
        im(padded_bins(bins)) {}

  std::vector<double> start_re, start_im, step_re, step_im, re, im;
};

}  // namespace

std::vector<Complex> exact_spectra(const SynthesisSetup& setup, const ScattererList& list,
                                   std::span<const std::complex<float>> amplitude,
                                   const KernelTable& kernels, const Workers& workers) {
  const int bins = setup.record.transform;
  const double bin_hz = setup.sonar.bandwidth_hz / bins;
  const double first_hz = setup.sonar.frequency_hz - bins / 2 * bin_hz;
  const double source_pa_m = source_pressure_pa_m(setup.sonar);
  const std::vector<Complex> pulse = pulse_spectrum(setup.sonar, bins);
  std::vector<Complex> spectra(std::size_t(setup.sonar.beam_count) * bins);
  workers.for_each(setup.sonar.beam_count, [&](std::size_t sector) {
    const std::uint32_t first = list.beam_offset[sector];
    const int count = static_cast<int>(list.beam_offset[sector + 1] - first);
    DoublePhasors p(count, bins);
    for (int i = 0; i < count; ++i) {
      const Scatterer& s = list.items[first + i];
      const Complex start = Complex(amplitude[first + i]) * static_cast<double>(s.gain) *
                            std::polar(1.0, -2 * kPi * carrier_turns(first_hz, s.delay_s));
      const Complex step = std::polar(1.0, -2 * kPi * carrier_turns(bin_hz, s.delay_s));
      p.start_re[i] = start.real();
      p.start_im[i] = start.imag();
      p.step_re[i] = step.real();
      p.step_im[i] = step.imag();
    }
    kernels.exact({p.start_re.data(), p.start_im.data(), p.step_re.data(), p.step_im.data(), count,
                   bins, p.re.data(), p.im.data()});
    for (int m = 0; m < bins; ++m) {
      const int bin = m < bins / 2 ? m + bins / 2 : m - bins / 2;
      spectra[sector * bins + bin] = source_pa_m * pulse[m] * Complex(p.re[m], p.im[m]);
    }
  });
  return spectra;
}

std::vector<Complex> exact_series(const SynthesisSetup& setup, std::vector<Complex> spectra,
                                  const Workers& workers) {
  const int beams = setup.sonar.beam_count, bins = setup.record.transform;
  const int samples = setup.record.samples;
  exact_inverse_transform(spectra.data(), bins, beams, workers);
  const Mixing mixing = make_mixing(setup.sonar);
  std::vector<Complex> series(std::size_t(beams) * samples);
  workers.for_each((samples + kMixColumns - 1) / kMixColumns, [&](std::size_t block) {
    const int first = static_cast<int>(block) * kMixColumns;
    const int columns = std::min(kMixColumns, samples - first);
    for (int j = 0; j < beams; ++j) {
      double sum[2 * kMixColumns] = {};
      for (int i = 0; i < beams; ++i) {
        const double w = mixing.scale[j] * mixing.weight[std::abs(i - j)];
        const auto* row =
            reinterpret_cast<const double*>(spectra.data() + std::size_t(i) * bins + first);
        for (int c = 0; c < 2 * columns; ++c) sum[c] += w * row[c];
      }
      for (int c = 0; c < columns; ++c) {
        series[std::size_t(j) * samples + first + c] = {sum[2 * c], sum[2 * c + 1]};
      }
    }
  });
  return series;
}

SeriesError series_error(std::span<const std::complex<float>> series,
                         std::span<const Complex> exact, int beams) {
  const std::size_t samples = exact.size() / beams;
  double wrong[kTenths] = {}, whole[kTenths] = {};
  for (std::size_t cell = 0; cell < exact.size(); ++cell) {
    const std::size_t tenth = cell % samples * kTenths / samples;
    wrong[tenth] += std::norm(Complex(series[cell]) - exact[cell]);
    whole[tenth] += std::norm(exact[cell]);
  }
  double all_wrong = 0, all = 0;
  for (int t = 0; t < kTenths; ++t) {
    all_wrong += wrong[t];
    all += whole[t];
  }
  SeriesError error{std::sqrt(all_wrong / all), 0};
  for (int t = 0; t < kTenths; ++t) {
    if (whole[t] < kFaintTenth * kFaintTenth * all) continue;
    error.worst_tenth = std::max(error.worst_tenth, std::sqrt(wrong[t] / whole[t]));
  }
  return error;
}

}  // namespace ensonify
