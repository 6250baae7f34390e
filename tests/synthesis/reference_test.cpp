// V8: the CPU backend against the double-precision direct sum, from the same scatterers. V1 to V3 and V15 are in
// tests/verification, which measures them on the program's files.
#include "catch.h"
#include "synthesis/v8.h"

using namespace ensonify;
using namespace ensonify::test;

// Protects level and carrier phase of the stored series: S0 a / r^2 e^(-i 2 pi f_c tau) at the echo's peak.
TEST_CASE("the carrier phase stays in the series") {
  const bool reference = GENERATE(true, false);
  const Sonar sonar = p900(9, 9, 8);
  const SynthesisSetup setup = setup_of(sonar);
  const double range_m = sample_range_m(sonar, setup.water, 150);
  const ScattererList list = sorted_by_beam_and_delay({point_target(sonar, 4, range_m, -40)}, 9);
  const auto backend = reference ? make_reference_backend(setup) : make_cpu_backend(setup);
  const PingSeries series = synthesize(*backend, list);
  const double turns = carrier_turns(900e3, two_way_delay_s(range_m, 1500));
  const std::complex<double> expected =
      std::polar(1e5 * 0.01 / (range_m * range_m), -2 * kPi * turns);
  const std::complex<double> obtained(series.pressure_pa[4 * setup.record.samples + 150]);
  CHECK(std::abs(obtained - expected) < 1e-6 * std::abs(expected));
}

TEST_CASE("V8: random scatterers over the whole record, every tolerance and level") {
  const Sonar sonar = p900(48, 48, 10);
  require_agreement({.sonar = sonar,
                     .scatterers = random_scatterers(sonar, 1500, 0.6, 21),
                     .judged_tenths = 9,
                     .tolerances = {1e-3, 1e-4, 1e-5, 1e-6, 1e-7},
                     .levels = all_levels()});
}

// Protects the few nodes that stand for many beams, with both patterns' ends in the fan.
TEST_CASE("V8: beams much denser than their width") {
  Sonar sonar = p900(160, 28, 3);
  sonar.normalization = GENERATE(Normalization::calibrated, Normalization::mean_square);
  sonar.shading.kind = GENERATE(Shading::uniform, Shading::chebyshev);
  std::vector<Scatterer> scatterers = random_scatterers(sonar, 400, 0.4, 29);
  for (const int beam : {0, 1, 159}) scatterers.push_back(point_target(sonar, beam, 1.1, -10));
  require_agreement({.sonar = sonar,
                     .scatterers = scatterers,
                     .judged_tenths = 9,
                     .tolerances = {1e-3, 1e-5, 1e-6}});
}

// 99 dB and what the targets differ by: echoes at 60 m under one of 0 dB at 1.5 m.
TEST_CASE("V8: a strong echo at 1.5 m before a faint far field", "[figure]") {
  const double far_db = GENERATE(-40, -120);
  const Sonar sonar = p900(4, 2, 60);
  require_agreement({.sonar = sonar,
                     .scatterers = strong_before_faint(sonar, 40, 20, far_db),
                     .judged_tenths = 1,
                     .tolerances = {1e-4, 1e-5, 1e-6, 1e-7}});
}

TEST_CASE("V8: a strong echo and a field within 120 dB of it") {
  const Sonar sonar = p900(16, 16, 30);
  std::vector<Scatterer> scatterers = random_scatterers(sonar, 600, 10, 22);
  scatterers.push_back(point_target(sonar, 7, 1.5, 20));
  require_agreement({.sonar = sonar,
                     .scatterers = scatterers,
                     .judged_tenths = 5,
                     .tolerances = {1e-3, 1e-5, 1e-6, 1e-7}});
}

TEST_CASE("V8: short fans") {
  const int beams = GENERATE(1, 2, 3, 16);
  const Sonar sonar = p900(beams, beams * 0.5, 4);
  require_agreement({.sonar = sonar,
                     .scatterers = random_scatterers(sonar, 100, 0.3, 23),
                     .judged_tenths = 8,
                     .levels = all_levels()});
}

TEST_CASE("V8: both ends of the record and the mean-square normalization") {
  Sonar sonar = p900(12, 6, 5);
  sonar.normalization = Normalization::mean_square;
  std::vector<Scatterer> scatterers = random_scatterers(sonar, 50, 1, 24);
  scatterers.push_back(point_target(sonar, 0, 1e-3, -120));
  scatterers.push_back(point_target(sonar, 11, 5.0, 0));
  require_agreement({.sonar = sonar, .scatterers = scatterers, .judged_tenths = 9});
}

// Protects complex and narrow spectra, which fold differently in the power than real, even ones.
TEST_CASE("V8: every pulse and window") {
  Sonar sonar = p900(8, 4, 5);
  sonar.pulse = pulse_of(
      GENERATE(PulseShape::flat, PulseShape::lfm, PulseShape::cw, PulseShape::table), sonar);
  sonar.window = GENERATE(Window::none, Window::hamming);
  require_agreement({.sonar = sonar,
                     .scatterers = random_scatterers(sonar, 150, 0.5, 25),
                     .judged_tenths = 9,
                     .tolerances = {1e-3, 1e-5, 1e-7}});
}

TEST_CASE("V8: shaded beams") {
  Sonar sonar = p900(12, 6, 5);
  sonar.shading.kind = GENERATE(Shading::hann, Shading::taylor, Shading::chebyshev);
  require_agreement(
      {.sonar = sonar, .scatterers = random_scatterers(sonar, 150, 0.5, 27), .judged_tenths = 9});
}

// Protects the plain transform that the CPU takes for volumes, in sectors with and without
// scatterers, up to the last sample, far under a strong target; and the noise of samples.
TEST_CASE("V8: two volumes, with a target and without scatterers") {
  Sonar sonar = p900(9, 4.5, 6);
  sonar.pulse = pulse_of(GENERATE(PulseShape::gaussian, PulseShape::cw, PulseShape::table), sonar);
  sonar.shading.kind = Shading::taylor;
  const SynthesisSetup setup = setup_of(sonar);
  const std::vector<VolumeEcho> volumes = {
      volume_of(setup, [](int beam, int n) { return beam % 2 == 0 ? 1e-4 / (1.0 + n * n) : 0; }),
      volume_of(setup, [](int beam, int n) { return n % 7 == 0 ? 1e-9 * beam : 0; })};
  require_agreement({.sonar = sonar,
                     .scatterers = {},
                     .judged_tenths = 10,
                     .volumes = volumes,
                     .noise_power_pa2 = 1e-3});
  std::vector<Scatterer> scatterers;
  for (const Scatterer& s : random_scatterers(sonar, 100, 0.5, 28)) {
    if (s.beam != 4) scatterers.push_back(s);
  }
  scatterers.push_back(point_target(sonar, 7, 1.5, 20));
  require_agreement({.sonar = sonar,
                     .scatterers = scatterers,
                     .judged_tenths = 9,
                     .volumes = volumes,
                     .tolerances = {1e-5, 1e-6, 1e-7},
                     .levels = all_levels()});
}

// The paper's full calculation: 512 beams x 114 rays, 60 m. A minute or so for the reference.
TEST_CASE("V8: the full size", "[.][long]") {
  const Sonar sonar = p900(512, 90, 60);
  require_agreement({.sonar = sonar,
                     .scatterers = random_scatterers(sonar, 512 * 114, 1.5, 26),
                     .judged_tenths = 3,
                     .tolerances = {1e-3, 1e-5, 1e-6, 1e-7}});
}
