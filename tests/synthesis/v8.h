// V8 as a check: the CPU backend against the reference.
#pragma once

#include <algorithm>
#include <complex>
#include <span>
#include <vector>

#include "catch.h"
#include "synthesis/ping_fixture.h"

namespace ensonify::test {

struct Norms {
  double error = 0, reference = 0;
  double ratio() const { return std::sqrt(error / reference); }
};

// Samples [first, last) of every beam.
inline Norms compare(const std::vector<std::complex<double>>& obtained,
                     const std::vector<std::complex<double>>& expected, int samples, int first,
                     int last) {
  Norms norms;
  for (std::size_t at = 0; at < expected.size(); ++at) {
    const int n = static_cast<int>(at % samples);
    if (n < first || n >= last) continue;
    norms.error += std::norm(obtained[at] - expected[at]);
    norms.reference += std::norm(expected[at]);
  }
  return norms;
}

// The whole record and its tenths, those aside that hold less than `least` of the record's norm.
inline void require_within(const std::vector<std::complex<double>>& obtained,
                           const std::vector<std::complex<double>>& expected, int samples,
                           double tolerance, double tenfold, double least, int judged_tenths) {
  const Norms whole = compare(obtained, expected, samples, 0, samples);
  CHECK(whole.ratio() <= tolerance);
  int judged = 0;
  for (int tenth = 0; tenth < 10; ++tenth) {
    const Norms part =
        compare(obtained, expected, samples, samples * tenth / 10, samples * (tenth + 1) / 10);
    if (part.reference < least * least * whole.reference) continue;
    ++judged;
    INFO("tenth " << tenth);
    CHECK(part.ratio() <= tenfold);
  }
  CHECK(judged >= judged_tenths);
}

inline std::vector<std::complex<double>> widened(std::span<const std::complex<float>> series) {
  return {series.begin(), series.end()};
}

inline std::vector<std::complex<double>> widened(std::span<const float> power) {
  return {power.begin(), power.end()};
}

// V8: a tolerance over the record and ten times that in each tenth that holds at least 1e-6 of its
// norm. Expected power: 1e-4 and 1e-3, in tenths down to 1e-10; from tolerances that are held in
// double precision every pixel to 1e-4 or to 1e-11 of the maximum: delays of 1e3 periods round to
// 1e-13 of one, which leaves either route a floor near 1e-12.
struct V8 {
  Sonar sonar;
  std::vector<Scatterer> scatterers;
  int judged_tenths = 0;
  std::vector<VolumeEcho> volumes = {};
  std::vector<double> tolerances = {1e-5, 1e-7};
  std::vector<SimdLevel> levels = {best_simd_level()};
  double noise_power_pa2 = 0;
  double max_doppler = 0;
};

inline void require_agreement(const V8& test) {
  SynthesisSetup setup = setup_of(test.sonar);
  setup.max_doppler = test.max_doppler;
  const int samples = setup.record.samples;
  const ScattererList list = sorted_by_beam_and_delay(test.scatterers, test.sonar.beam_count);
  const RandomKeys keys = keys_of_ping(0, 3);
  const PingSeries expected =
      synthesize(*make_reference_backend(setup), list, keys, test.noise_power_pa2, test.volumes);
  const float strongest =
      *std::max_element(expected.clean_power_pa2.begin(), expected.clean_power_pa2.end());
  for (const double tolerance : test.tolerances) {
    for (const SimdLevel level : test.levels) {
      INFO("tolerance " << tolerance << " " << simd_level_name(level));
      setup.tolerance = tolerance;
      setup.simd = level;
      const PingSeries obtained =
          synthesize(*make_cpu_backend(setup), list, keys, test.noise_power_pa2, test.volumes);
      require_within(widened(obtained.pressure_pa), widened(expected.pressure_pa), samples,
                     tolerance, 10 * tolerance, 1e-6, test.judged_tenths);
      if (tolerance >= 1e-6) {
        require_within(widened(obtained.clean_power_pa2), widened(expected.clean_power_pa2),
                       samples, 1e-4, 1e-3, 1e-10, test.judged_tenths);
        continue;
      }
      for (std::size_t i = 0; i < expected.clean_power_pa2.size(); ++i) {
        REQUIRE(obtained.clean_power_pa2[i] ==
                Approx(expected.clean_power_pa2[i]).epsilon(1e-4).margin(1e-11 * strongest));
      }
    }
  }
}

// All that this processor has.
inline std::vector<SimdLevel> all_levels() {
  std::vector<SimdLevel> levels;
  for (const SimdLevel level : {SimdLevel::sse4, SimdLevel::avx2, SimdLevel::avx512}) {
    if (level <= best_simd_level()) levels.push_back(level);
  }
  return levels;
}

}  // namespace ensonify::test
