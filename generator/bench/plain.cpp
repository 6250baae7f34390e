#include "bench/plain.h"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "acoustics/propagation.h"
#include "acoustics/pulse.h"
#include "core/units.h"
#include "synthesis/beamforming.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr int kTenths = 10;
constexpr double kFaintTenth = 1e-6;
// Samples of all beams that fit into a cache together.
constexpr int kMixColumns = 64;

// Rows of floats in whole panels of every level, and on 64-byte boundaries.
constexpr int kRowFloats = 48;

int stride_of(int bins) {
  const int panels = (2 * bins + kRowFloats - 1) / kRowFloats;
  return panels * kRowFloats / 2;
}

std::vector<float> packed_weights(const Mixing& mixing, int rows) {
  const int beams = mixing.beams();
  const int blocks = (beams + rows - 1) / rows;
  std::vector<float> packed(std::size_t(blocks) * rows * beams);
  for (int j = 0; j < beams; ++j) {
    for (int i = 0; i < beams; ++i) {
      packed[(std::size_t(j / rows) * beams + i) * rows + j % rows] =
          static_cast<float>(mixing.scale[j] * mixing.at(j, i));
    }
  }
  return packed;
}

std::uint64_t fixed_point_turns(double turns) {
  const double fraction = turns - std::floor(turns);
  // A tiny negative number rounds up to the whole turn.
  return fraction < 1 ? static_cast<std::uint64_t>(fraction * 18446744073709551616.0) : 0;
}

fftwf_complex* fftw_row(std::complex<float>* row) { return reinterpret_cast<fftwf_complex*>(row); }
fftw_complex* fftw_row(std::complex<double>* row) { return reinterpret_cast<fftw_complex*>(row); }

}  // namespace

std::vector<Complex> exact_bins(const SynthesisSetup& setup, std::span<const Complex> pulse,
                                std::span<const Scatterer> scatterers,
                                std::span<const std::complex<float>> amplitude,
                                const KernelTable& kernels,
                                const std::function<double(const Scatterer&)>& later_s) {
  const int bins = setup.record.transform, count = static_cast<int>(scatterers.size());
  const double bin_hz = setup.sonar.bandwidth_hz / bins;
  const double first_hz = setup.sonar.frequency_hz - bins / 2 * bin_hz;
  std::vector<double> start_re(count), start_im(count), step_re(count), step_im(count);
  std::vector<double> re(padded_bins(bins)), im(padded_bins(bins));
  for (int i = 0; i < count; ++i) {
    const Scatterer& s = scatterers[i];
    const double later = later_s(s);
    const double turns = carrier_turns(first_hz, s.delay_s) + first_hz * later;
    const Complex start = Complex(amplitude[i]) * static_cast<double>(s.gain) *
                          std::polar(1.0, -2 * kPi * (turns - std::rint(turns)));
    const Complex step = std::polar(1.0, -2 * kPi * carrier_turns(bin_hz, s.delay_s + later));
    start_re[i] = start.real();
    start_im[i] = start.imag();
    step_re[i] = step.real();
    step_im[i] = step.imag();
  }
  kernels.exact({start_re.data(), start_im.data(), step_re.data(), step_im.data(), count, bins,
                 re.data(), im.data()});
  std::vector<Complex> sums(bins);
  const double source_pa_m = source_pressure_pa_m(setup.sonar);
  for (int m = 0; m < bins; ++m) sums[m] = source_pa_m * pulse[m] * Complex(re[m], im[m]);
  return sums;
}

std::vector<Complex> exact_spectra(const SynthesisSetup& setup, const ScattererList& list,
                                   std::span<const std::complex<float>> amplitude,
                                   const KernelTable& kernels, const Workers& workers) {
  const int bins = setup.record.transform;
  const std::vector<Complex> pulse = pulse_spectrum(setup.sonar, bins);
  std::vector<Complex> spectra(std::size_t(setup.sonar.beam_count) * bins);
  workers.for_each(setup.sonar.beam_count, [&](std::size_t sector) {
    const std::uint32_t first = list.beam_offset[sector];
    const std::size_t count = list.beam_offset[sector + 1] - first;
    const std::vector<Complex> sums =
        exact_bins(setup, pulse, std::span(list.items).subspan(first, count),
                   amplitude.subspan(first, count), kernels, [](const Scatterer&) { return 0.0; });
    std::rotate_copy(sums.begin(), sums.begin() + bins / 2, sums.end(),
                     spectra.begin() + static_cast<std::ptrdiff_t>(sector * bins));
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
        const double w = mixing.scale[j] * mixing.at(j, i);
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

PlainPhasors::PlainPhasors(const SynthesisSetup& setup, std::size_t count)
    : re(padded_bins(setup.record.transform)),
      im(re.size()),
      bins_(setup.record.transform),
      bin_hz_(setup.sonar.bandwidth_hz / bins_),
      first_hz_(setup.sonar.frequency_hz - bins_ / 2 * bin_hz_),
      start_(count),
      step_(count),
      magnitude_(count),
      workspace_(2 * count) {}

void PlainPhasors::set(std::size_t i, std::complex<float> amplitude, double delay_s) {
  const double turns = std::arg(amplitude) * static_cast<float>(0.5 / kPi);
  start_[i] = fixed_point_turns(first_hz_ * delay_s - turns);
  step_[i] = fixed_point_turns(bin_hz_ * delay_s);
  magnitude_[i] = std::sqrt(std::norm(amplitude));
}

void PlainPhasors::sum(RaySum method, const KernelTable& kernels) {
  const auto sum_over = method == RaySum::direct ? kernels.direct : kernels.recurrence;
  sum_over({start_.data(), step_.data(), magnitude_.data(), static_cast<int>(start_.size()), bins_,
            re.data(), im.data(), workspace_.data()});
}

PlainMethod::PlainMethod(const SynthesisSetup& setup, const KernelTable& kernels)
    : setup_(setup),
      kernels_(kernels),
      stride_(stride_of(setup.record.transform)),
      weight_(packed_weights(make_mixing(setup.sonar), kernels.mix_rows)),
      sector_(std::size_t(setup.sonar.beam_count) * stride_),
      beam_(setup.record.transform, stride_, setup.sonar.beam_count) {
  const double source_pa_m = source_pressure_pa_m(setup.sonar);
  for (const std::complex<double>& s : pulse_spectrum(setup.sonar, setup.record.transform)) {
    pulse_re_.push_back(static_cast<float>(source_pa_m * s.real()));
    pulse_im_.push_back(static_cast<float>(source_pa_m * s.imag()));
  }
}

void PlainMethod::ray_sum(RaySum method, const ScattererList& list,
                          std::span<const std::complex<float>> amplitude,
                          std::span<const int> sectors, const Workers& workers) {
  const int bins = setup_.record.transform;
  workers.for_each(sectors.size(), [&](std::size_t k) {
    const int sector = sectors[k];
    const std::uint32_t first = list.beam_offset[sector];
    const std::size_t count = list.beam_offset[sector + 1] - first;
    PlainPhasors p(setup_, count);
    for (std::size_t i = 0; i < count; ++i) {
      const Scatterer& s = list.items[first + i];
      p.set(i, amplitude[first + i] * s.gain, s.delay_s);
    }
    p.sum(method, kernels_);
    auto* row = reinterpret_cast<float*>(sector_.data() + std::size_t(sector) * stride_);
    const int half = bins / 2;
    const auto shape = [&](int from, int to, int many) {
      kernels_.shape({p.re.data() + from, p.im.data() + from, pulse_re_.data() + from,
                      pulse_im_.data() + from, many, row + 2 * to});
    };
    shape(0, half, half);
    shape(half, 0, half);
  });
}

void PlainMethod::mix(const Workers& workers) {
  const int beams = setup_.sonar.beam_count;
  const auto* in = reinterpret_cast<const float*>(sector_.data());
  auto* out = reinterpret_cast<float*>(beam_.data());
  const int columns = kernels_.mix_columns;
  workers.for_each(2 * stride_ / columns, [&](std::size_t panel) {
    std::vector<float> workspace(std::size_t(beams) * columns);
    kernels_.mix({weight_.data(), in, out, beams, 2 * stride_, static_cast<int>(panel) * columns,
                  workspace.data()});
  });
}

void PlainMethod::transform(std::vector<std::complex<float>>& series, const Workers& workers) {
  const int samples = setup_.record.samples;
  series.resize(std::size_t(setup_.sonar.beam_count) * samples);
  beam_.run(series.data(), samples, workers);
}

FftRows::FftRows(int length, int stride, int rows)
    : length_(length), stride_(stride), rows_(rows), rows_of_bins_(std::size_t(rows) * stride) {
  AlignedBuffer<std::complex<float>> out(length);
  plan_ = fftwf_plan_dft_1d(length, fftw_row(data()), fftw_row(out.data()), FFTW_BACKWARD,
                            FFTW_MEASURE);
  std::fill(rows_of_bins_.begin(), rows_of_bins_.end(), 0);  // measuring wrote into them
}

FftRows::~FftRows() { fftwf_destroy_plan(static_cast<fftwf_plan>(plan_)); }

void FftRows::run(std::complex<float>* out, int samples, const Workers& workers) {
  workers.for_each(rows_, [&](std::size_t j) {
    AlignedBuffer<std::complex<float>> row(length_);
    fftwf_execute_dft(static_cast<fftwf_plan>(plan_), fftw_row(data() + j * stride_),
                      fftw_row(row.data()));
    std::copy(row.data(), row.data() + samples, out + j * samples);
  });
}

void exact_inverse_transform(std::complex<double>* rows, int length, int count,
                             const Workers& workers) {
  const fftw_plan plan = fftw_plan_dft_1d(length, fftw_row(rows), fftw_row(rows), FFTW_BACKWARD,
                                          FFTW_ESTIMATE | FFTW_UNALIGNED);
  workers.for_each(count, [&](std::size_t j) {
    fftw_complex* row = fftw_row(rows + j * length);
    fftw_execute_dft(plan, row, row);
  });
  fftw_destroy_plan(plan);
}

}  // namespace ensonify
