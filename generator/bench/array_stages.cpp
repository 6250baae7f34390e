#include "bench/stages.h"

#include <algorithm>
#include <cmath>

#include "acoustics/propagation.h"
#include "acoustics/pulse.h"
#include "bench/machine.h"
#include "bench/plain.h"
#include "core/units.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/array_nodes.h"
#include "synthesis/cpu/array_records.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// One element's record in frequency, f_c - b/2 first.
std::vector<Complex> exact_element(const Bench& bench, const ArrayGeometry& geometry, int element,
                                   const ScattererList& list,
                                   const std::vector<std::complex<float>>& amplitude) {
  const SynthesisSetup& setup = bench.setup;
  return exact_bins(setup, pulse_spectrum(setup.sonar, setup.record.transform), list.items,
                    amplitude, best_kernels(), [&](const Scatterer& s) {
                      return element_delay_s(apparent_point_m(s), geometry.y_m[element],
                                             setup.water.sound_speed_m_s);
                    });
}

std::vector<Complex> exact_beam(const Bench& bench, const ArrayGeometry& geometry,
                                const std::vector<std::vector<Complex>>& spectra, int beam) {
  const SynthesisSetup& setup = bench.setup;
  const int bins = setup.record.transform, half = bins / 2;
  const double azimuth = beam_azimuth_rad(setup.sonar, beam), c = setup.water.sound_speed_m_s;
  std::vector<Complex> sum(setup.record.samples), turned(bins);
  const Workers one(1);
  for (std::size_t n = 0; n < spectra.size(); ++n) {
    const double y = geometry.y_m[n], later = steering_delay_s(y, azimuth, c);
    for (int m = 0; m < bins; ++m) {
      const double nu = (m - half) * setup.sonar.bandwidth_hz / bins;
      turned[(m + half) % bins] = spectra[n][m] * std::polar(1.0, 2 * kPi * nu * later);
    }
    exact_inverse_transform(turned.data(), bins, 1, one);
    for (int t = 0; t < setup.record.samples; ++t) {
      const double range_m = focus_range_m(setup.sonar, setup.water, t);
      const double delay_s = later + focus_delay_s(y, azimuth, range_m, c);
      const double turns = carrier_turns(setup.sonar.frequency_hz, delay_s);
      sum[t] += std::polar(geometry.weight[n], 2 * kPi * turns) * turned[t];
    }
  }
  return sum;
}

// One element's sum over evenly spread scatterers.
void plain_element(const Bench& bench, const ScattererList& list,
                   const std::vector<std::complex<float>>& amplitude, RaySum method, double y_m,
                   std::size_t step) {
  const SynthesisSetup& setup = bench.setup;
  PlainPhasors phasors(setup, (list.size() + step - 1) / step);
  for (std::size_t i = 0; i < list.size(); i += step) {
    const Scatterer& s = list.items[i];
    const double later_s = element_delay_s(apparent_point_m(s), y_m, setup.water.sound_speed_m_s);
    phasors.set(i / step, amplitude[i] * s.gain, s.delay_s + later_s);
  }
  phasors.sum(method, best_kernels());
}

}  // namespace

SeriesError check_array(const Bench& bench, const ScattererList& list,
                        const std::vector<std::complex<float>>& amplitude, const PingSeries& series,
                        int beams, const Workers& workers) {
  const ArrayGeometry geometry = make_array_geometry(bench.setup.sonar);
  const int elements = static_cast<int>(geometry.y_m.size());
  const int all = bench.setup.sonar.beam_count, samples = bench.setup.record.samples;
  std::vector<std::vector<Complex>> spectra(elements);
  workers.for_each(elements, [&](std::size_t n) {
    spectra[n] = exact_element(bench, geometry, static_cast<int>(n), list, amplitude);
  });
  const int count = std::min(beams, all);
  std::vector<Complex> exact(std::size_t(count) * samples);
  std::vector<std::complex<float>> got(exact.size());
  for (int i = 0; i < count; ++i) {
    const int beam = static_cast<int>((i + 0.5) * all / count);
    const std::vector<Complex> sum = exact_beam(bench, geometry, spectra, beam);
    std::copy(sum.begin(), sum.end(), exact.begin() + std::ptrdiff_t(i) * samples);
    std::copy_n(series.pressure_pa.begin() + std::ptrdiff_t(beam) * samples, samples,
                got.begin() + std::ptrdiff_t(i) * samples);
  }
  return series_error(got, exact, count);
}

PlainTimes time_plain_array(const Bench& bench, const ScattererList& list,
                            const std::vector<std::complex<float>>& amplitude,
                            const Workers& workers, CaseReport* report) {
  constexpr int kStep = 4;
  const ArrayGeometry geometry = make_array_geometry(bench.setup.sonar);
  const int elements = static_cast<int>(geometry.y_m.size()), threads = workers.threads();
  const auto time_of = [&](RaySum method, const char* name) {
    const double ms = median_ms(bench.options.seconds, [&] {
      workers.for_each(threads, [&](std::size_t n) {
        plain_element(bench, list, amplitude, method, geometry.y_m[n % elements], kStep);
      });
    });
    const double part = threads / double(elements) / kStep;
    if (report != nullptr) report->references.push_back({name, ms / part, part, 0, ""});
    return ms / part;
  };
  const double direct = time_of(RaySum::direct, "ray_sum_direct");
  return {direct, time_of(RaySum::recurrence, "ray_sum_recurrence")};
}

void time_array_stages(const Bench& bench, const ScattererList& list, CaseReport& report) {
  const SynthesisSetup& setup = bench.setup;
  const SynthesisTables tables{
      setup, make_mixing(setup.sonar), pulse_spectrum(setup.sonar, setup.record.transform), {}};
  const std::shared_ptr<const ArrayPlan> plan = make_array_plan(tables);
  if (!plan) return;
  const std::shared_ptr<const ArrayNodes> nodes = make_array_nodes(*plan);
  const Kernels& kernels = kernels_of(setup.simd);
  const PingTask task{&list, bench.keys, 0, {}};
  const Workers one(1);
  ArrayEchoes echoes;
  Pool<PointChunk> chunks;
  Pool<RecordScratch> records;
  Pool<SteerScratch> steering;
  AlignedBuffer<Complex> spectra;
  FineRecords fine;
  NodeRecords node_records;
  std::vector<std::complex<float>> series(std::size_t(plan->beams()) * plan->samples());
  const int near = nodes ? nodes->near_samples : plan->samples();
  const double seconds = bench.options.seconds;
  const auto add = [&](const char* name, double ms) { report.stages.push_back({name, ms}); };
  add("speckle", median_ms(seconds, [&] {
        gather_echoes(*plan, kernels, task, EchoAmplitude::drawn, chunks, one, echoes);
      }));
  add("ray_sum_and_fft", median_ms(seconds, [&] {
        element_spectra(*plan, kernels, task, echoes, EchoAmplitude::drawn, records, one, spectra);
      }));
  add("near_beams", median_ms(seconds, [&] {
        make_fine_records(*plan, spectra, near, records, one, fine);
        direct_beams(*plan, kernels, fine, near, one, series.data());
      }));
  if (!nodes) return;
  add("mixing", median_ms(seconds, [&] {
        node_beams(*plan, *nodes, kernels, spectra, steering, one, node_records, series.data());
      }));
}

}  // namespace ensonify
