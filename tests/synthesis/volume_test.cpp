// Reverberation of the water, from its energies to the series.
#include "catch.h"
#include "synthesis/beamforming.h"
#include "synthesis/direct_sum.h"
#include "synthesis/statistics.h"

using namespace ensonify;
using namespace ensonify::test;

// V14, synthesis' half: where all cells hold E, clean = S0^2 E sum_i (B/N_j)^2 b int |s|^2 dt,
// whatever the pulse; and the mean |p|^2 over 300 pings is that. Its standard error is that of the
// pings' own spread, under 1 % each.
TEST_CASE("V14: water of constant energy") {
  Sonar sonar = p900(9, 4.5, 4);
  sonar.pulse = pulse_of(GENERATE(PulseShape::gaussian, PulseShape::cw, PulseShape::table), sonar);
  sonar.normalization = GENERATE(Normalization::calibrated, Normalization::mean_square);
  const SynthesisSetup setup = setup_of(sonar);
  const double energy = 3e-7;
  const std::vector<VolumeEcho> water = {volume_of(setup, [&](int, int) { return energy / 4; }),
                                         volume_of(setup, [&](int, int) { return energy * 0.75; })};
  const Mixing mixing = make_mixing(sonar);
  const double unit = 1e10 * energy * DirectSum(setup).pulse_energy();
  std::vector<double> expected(9);
  for (int j = 0; j < 9; ++j) {
    for (int i = 0; i < 9; ++i) {
      expected[j] += unit * std::pow(mixing.weight[std::abs(i - j)] * mixing.scale[j], 2);
    }
  }
  const int first = 60, last = setup.record.samples - 60;
  std::vector<double> ratio;
  PingSeries series;
  for_each_ping(setup, sorted_by_beam_and_delay({}, 9), water, 300, [&](const PingSeries& ping) {
    series = ping;
    double sum = 0;
    for (int j = 0; j < 9; ++j) {
      for (int n = first; n < last; ++n) {
        sum += std::norm(pressure(setup, ping, j, n)) / expected[j];
      }
    }
    ratio.push_back(sum / (9 * (last - first)));
  });
  for (int j = 0; j < 9; ++j) {
    for (int n = first; n < last; n += 5) {
      REQUIRE(series.clean_power_pa2[j * setup.record.samples + n] ==
              Approx(expected[j]).epsilon(1e-6));
    }
  }
  const Estimate mean = mean_of(ratio);
  CHECK(mean.error < 0.01);
  CHECK(mean.value == Approx(1).margin(3 * mean.error));
}

// Protects what the keys say: a volume's draw depends on its cell and ping alone, and its echo
// peaks in its own sector at its own sample with no mean of its own.
TEST_CASE("one cell of water is a scatterer on its sample") {
  Sonar sonar = p900(5, 2.5, 2);
  sonar.pulse = pulse_of(GENERATE(PulseShape::gaussian, PulseShape::table), sonar);
  SynthesisSetup setup = setup_of(sonar);
  setup.tolerance = 1e-7;
  const std::vector<VolumeEcho> water = {
      volume_of(setup, [](int beam, int n) { return beam == 3 && n == 30 ? 4e-8 : 0; })};
  const ScattererList nothing = sorted_by_beam_and_delay({}, 5);
  const RandomKeys keys = keys_of_ping(7);
  const bool reference = GENERATE(true, false);
  const auto backend = reference ? make_reference_backend(setup) : make_cpu_backend(setup);
  const PingSeries series = synthesize(*backend, nothing, keys, 0, water);
  const ComplexDraw xi = complex_normal(keys.volume, 7, (std::uint64_t{3} << 32) | 30, 0);
  const DirectSum direct(setup);
  for (int beam = 0; beam < 5; ++beam) {
    for (int n = 0; n < setup.record.samples; ++n) {
      const std::complex<double> unit = 1e5 * 2e-4 * direct.pattern(3, beam) * direct.pulse(n - 30);
      const std::complex<double> expected = unit * std::complex<double>(xi.re, xi.im);
      REQUIRE(std::abs(pressure(setup, series, beam, n) - expected) < 1e-6);
      REQUIRE(series.clean_power_pa2[beam * setup.record.samples + n] ==
              Approx(std::norm(unit)).margin(1e-8));
    }
  }
}
