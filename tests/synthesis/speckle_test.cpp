// Speckle against its theory; contrast and distribution are in tests/verification/speckle.py. Draws are pings: one pixel of many pings is a set of independent
// numbers, so that no correlation between pixels enters the standard errors.
#include "catch.h"
#include "synthesis/direct_sum.h"
#include "synthesis/statistics.h"

using namespace ensonify;
using namespace ensonify::test;

// V4: E p p'* over bins and beams is the point spread function's, of a wall and water together.
// 6,000 draws: with E|p|^2 = 1 either part of the estimate has a variance of
// (1 +- Re(rho^2)) / 2n, a standard error of at most 0.013.
TEST_CASE("V4: lag correlation is that of the point spread function", "[figure]") {
  Sonar sonar = p900(7, 1.75, 0.6);
  sonar.pulse = pulse_of(GENERATE(PulseShape::gaussian, PulseShape::table), sonar);
  const SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = sorted_by_beam_and_delay(wall(setup, 24, 0, 1, 23), 7);
  const std::vector<VolumeEcho> water = {
      volume_of(setup, [](int beam, int n) { return 1e-6 * (beam + n); })};
  constexpr int kPings = 6000, kBeam = 1, kBin = 9;
  struct Lag {
    int beam, bin;
    std::complex<double> sum;
  };
  std::vector<Lag> lags;
  for (int bin = 0; bin <= 5; ++bin) lags.push_back({kBeam, kBin + bin, 0});
  for (int beam = 1; beam <= 5; ++beam) lags.push_back({kBeam + beam, kBin, 0});
  for (int both = 1; both <= 3; ++both) lags.push_back({kBeam + both, kBin - both, 0});
  for_each_ping(setup, list, water, kPings, [&](const PingSeries& series) {
    const std::complex<double> here = pressure(setup, series, kBeam, kBin);
    for (Lag& lag : lags) lag.sum += here * std::conj(pressure(setup, series, lag.beam, lag.bin));
  });
  const DirectSum direct(setup);
  const double here = direct.covariance(list, water, kBeam, kBin, kBeam, kBin).real();
  for (const Lag& lag : lags) {
    const double there =
        direct.covariance(list, water, lag.beam, lag.bin, lag.beam, lag.bin).real();
    const double scale = std::sqrt(here * there);
    const std::complex<double> rho =
        direct.covariance(list, water, kBeam, kBin, lag.beam, lag.bin) / scale;
    const std::complex<double> estimate = lag.sum / (kPings * scale);
    const double split = (rho * rho).real();
    INFO("beams +" << lag.beam - kBeam << " bins +" << lag.bin - kBin << " rho " << rho);
    CHECK(estimate.real() ==
          Approx(rho.real()).margin(3 * std::sqrt((1 + split) / (2.0 * kPings))));
    CHECK(
        estimate.imag() ==
        Approx(rho.imag()).margin(3 * std::sqrt(std::max(0.0, 1 - split) / (2.0 * kPings)) + 1e-6));
  }
}

// V5: two waters, a point target and a wall with a constant part, told apart by where they lie.
// 3,000 pings leave standard errors of 0.004 (water and wall) and 0.006 (target) by the pings' own
// spread, three of which are 0.08 dB.
TEST_CASE("V5: mean power over pings equals clean", "[figure]") {
  const Sonar sonar = p900(5, 2.5, 1.5);
  const SynthesisSetup setup = setup_of(sonar);
  std::vector<Scatterer> scatterers = wall(setup, 60, 0.3, 36, 54);
  scatterers.push_back(point_target(sonar, 2, 22.3 * 1500 / (2 * sonar.bandwidth_hz), -40));
  const ScattererList list = sorted_by_beam_and_delay(scatterers, 5);
  const std::vector<VolumeEcho> water = {
      volume_of(setup, [](int beam, int n) { return n < 30 ? 1e-5 * (1 + beam) / (1 + n) : 0; }),
      volume_of(setup, [](int, int n) { return 1e-6 * n; })};
  const struct {
    const char* name;
    int first, last;
    std::vector<double> ratio;
  } windows[] = {{"water", 2, 16, {}}, {"target", 20, 25, {}}, {"wall", 37, 53, {}}};
  auto measured = std::to_array(windows);
  PingSeries last;
  for_each_ping(setup, list, water, 3000, [&](const PingSeries& series) {
    last = series;
    for (auto& window : measured) {
      double sum = 0;
      for (int beam = 0; beam < 5; ++beam) {
        for (int n = window.first; n < window.last; ++n) {
          sum += std::norm(pressure(setup, series, beam, n)) /
                 series.clean_power_pa2[beam * setup.record.samples + n];
        }
      }
      window.ratio.push_back(sum / (5 * (window.last - window.first)));
    }
  });
  for (const auto& window : measured) {
    const Estimate mean = mean_of(window.ratio);
    INFO(window.name << " " << mean.value << " +- " << mean.error);
    CHECK(10 * std::log10(1 + 3 * mean.error) < 0.1);
    CHECK(10 * std::log10(mean.value) == Approx(0).margin(0.1));
    CHECK(mean.value == Approx(1).margin(3 * mean.error));
  }
  const DirectSum direct(setup);
  for (int beam = 0; beam < 5; ++beam) {
    for (const int n : {4, 22, 23, 45}) {
      const double expected = std::norm(direct.mean(list, beam, n)) +
                              direct.covariance(list, water, beam, n, beam, n).real();
      CHECK(last.clean_power_pa2[beam * setup.record.samples + n] ==
            Approx(expected).epsilon(1e-5));
    }
  }
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
