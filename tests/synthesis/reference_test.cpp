// V8: the CPU backend against the double-precision direct sum, from the same scatterers.
#include <algorithm>

#include "catch.h"
#include "synthesis/ping_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

struct Norms {
  double error = 0, reference = 0;
  double ratio() const { return std::sqrt(error / reference); }
};

// Samples [first, last) of every beam.
Norms compare(const std::vector<std::complex<double>>& obtained,
              const std::vector<std::complex<double>>& expected, int samples, int first, int last) {
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
void require_within(const std::vector<std::complex<double>>& obtained,
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

std::vector<std::complex<double>> widened(const std::vector<std::complex<float>>& series) {
  return {series.begin(), series.end()};
}

std::vector<std::complex<double>> widened(const std::vector<float>& power) {
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
};

void require_agreement(const V8& test) {
  SynthesisSetup setup = setup_of(test.sonar);
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
std::vector<SimdLevel> all_levels() {
  std::vector<SimdLevel> levels;
  for (const SimdLevel level : {SimdLevel::sse4, SimdLevel::avx2, SimdLevel::avx512}) {
    if (level <= best_simd_level()) levels.push_back(level);
  }
  return levels;
}

}  // namespace

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
TEST_CASE("V8: a strong echo at 1.5 m before a faint far field") {
  const double far_db = GENERATE(-40, -80, -120);
  const Sonar sonar = p900(8, 4, 60);
  std::vector<Scatterer> scatterers;
  for (int i = 0; i < 40; ++i) {
    const double range_m = i == 0 ? 1.5 : 20 + i;
    Scatterer s = point_target(sonar, (3 * i) % 8, range_m, i == 0 ? 0 : far_db);
    s.gain = static_cast<float>(two_way_loss(range_m, 0.3));
    s.key = i;
    if (i % 2 == 1) {
      s.standard_deviation = s.mean.real();
      s.mean = 0;
    }
    scatterers.push_back(s);
  }
  require_agreement({.sonar = sonar,
                     .scatterers = scatterers,
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
