#include "bench/plain.h"

#include <cmath>
#include <cstdlib>

#include "acoustics/pulse.h"
#include "core/units.h"
#include "synthesis/mixing.h"

namespace ensonify {
namespace {

// Rows of floats in whole panels of every level, and on 64-byte boundaries.
constexpr int kRowFloats = 48;

int stride_of(int bins) {
  const int panels = (2 * bins + kRowFloats - 1) / kRowFloats;
  return panels * kRowFloats / 2;
}

std::vector<float> packed_weights(const Mixing& mixing, int rows) {
  const int beams = static_cast<int>(mixing.weight.size());
  const int blocks = (beams + rows - 1) / rows;
  std::vector<float> packed(std::size_t(blocks) * rows * beams);
  for (int j = 0; j < beams; ++j) {
    for (int i = 0; i < beams; ++i) {
      packed[(std::size_t(j / rows) * beams + i) * rows + j % rows] =
          static_cast<float>(mixing.scale[j] * mixing.weight[std::abs(i - j)]);
    }
  }
  return packed;
}

struct FixedPointPhasors {
  explicit FixedPointPhasors(std::size_t count, int bins)
      : start(count),
        step(count),
        magnitude(count),
        workspace(2 * count),
        re(padded_bins(bins)),
        im(padded_bins(bins)) {}

  std::vector<std::uint64_t> start, step;
  std::vector<float> magnitude, workspace, re, im;
};

}  // namespace

std::uint64_t fixed_point_turns(double turns) {
  const double fraction = turns - std::floor(turns);
  // A tiny negative number rounds up to the whole turn.
  return fraction < 1 ? static_cast<std::uint64_t>(fraction * 18446744073709551616.0) : 0;
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
  const double bin_hz = setup_.sonar.bandwidth_hz / bins;
  const double first_hz = setup_.sonar.frequency_hz - bins / 2 * bin_hz;
  const auto sum_over = method == RaySum::direct ? kernels_.direct : kernels_.recurrence;
  workers.for_each(sectors.size(), [&](std::size_t k) {
    const int sector = sectors[k];
    const std::uint32_t first = list.beam_offset[sector];
    const int count = static_cast<int>(list.beam_offset[sector + 1] - first);
    FixedPointPhasors p(count, bins);
    for (int i = 0; i < count; ++i) {
      const Scatterer& s = list.items[first + i];
      const std::complex<float> a = amplitude[first + i] * s.gain;
      const double turns = std::arg(a) * static_cast<float>(0.5 / kPi);
      // Conjugate: the sum turns forwards, an echo's phase backwards.
      p.start[i] = fixed_point_turns(first_hz * s.delay_s - turns);
      p.step[i] = fixed_point_turns(bin_hz * s.delay_s);
      p.magnitude[i] = std::sqrt(a.real() * a.real() + a.imag() * a.imag());
    }
    sum_over({p.start.data(), p.step.data(), p.magnitude.data(), count, bins, p.re.data(),
              p.im.data(), p.workspace.data()});
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

}  // namespace ensonify
