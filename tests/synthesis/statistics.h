// Draws of many pings and what is estimated from them.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "synthesis/ping_fixture.h"

namespace ensonify::test {

// A diffuse wall through the whole record: `per_beam` scatterers a sector at random delays and of
// random strengths, K/(K+1) of their energy constant.
inline std::vector<Scatterer> wall(const SynthesisSetup& setup, int per_beam, double k,
                                   double first_sample, double last_sample) {
  std::vector<Scatterer> scatterers;
  for (int beam = 0; beam < setup.sonar.beam_count; ++beam) {
    for (int i = 0; i < per_beam; ++i) {
      Scatterer s;
      s.key = std::uint64_t(beam) * per_beam + i;
      const double sample = first_sample + (last_sample - first_sample) * uniform(41, 0, s.key, 0);
      const double rms = 0.01 * (0.2 + uniform(41, 0, s.key, 1));
      s.delay_s = sample / setup.sonar.bandwidth_hz;
      s.gain = 0.5f;
      s.mean = static_cast<float>(rms * std::sqrt(k / (k + 1)));
      s.standard_deviation = static_cast<float>(rms / std::sqrt(k + 1));
      s.beam = static_cast<std::uint32_t>(beam);
      scatterers.push_back(s);
    }
  }
  return scatterers;
}

// visit(series) for pings 0 .. count-1, every one with draws of its own.
template <class Visit>
void for_each_ping(const SynthesisSetup& setup, const ScattererList& list,
                   std::span<const VolumeEcho> volumes, int count, Visit&& visit) {
  const auto backend = make_cpu_backend(setup);
  const Workers workers(1);
  for (int ping = 0; ping < count; ++ping) {
    visit(synthesize(*backend, list, keys_of_ping(ping), 0, volumes, workers));
  }
}

inline std::complex<double> pressure(const SynthesisSetup& setup, const PingSeries& series,
                                     int beam, int n) {
  return std::complex<double>(series.pressure_pa[std::size_t(beam) * setup.record.samples + n]);
}

struct Estimate {
  double value = 0, error = 0;  // of one standard error
};

inline Estimate mean_of(const std::vector<double>& x) {
  double sum = 0, squares = 0;
  for (const double value : x) sum += value;
  const double mean = sum / x.size();
  for (const double value : x) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / x.size() / x.size())};
}

}  // namespace ensonify::test
