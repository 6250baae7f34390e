// Speckle against its theory: the mean power is the clean one, and its intensity is exponential.
#include "catch.h"
#include "synthesis/ping_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

// V5 in small, and the contrast of V4: a diffuse wall, 1,500 pings, 6 beams 2.4 deg apart and 8
// samples 5 apart: 72,000 intensities, nearly independent: standard error of the mean 0.016 dB
// (3 of them: 0.05 dB), of the contrast about 1/sqrt(n) = 0.0037.
TEST_CASE("V5: mean power over pings equals clean, V4: contrast one") {
  const Sonar sonar = p900(64, 19.2, 3);
  const SynthesisSetup setup = setup_of(sonar);
  std::vector<Scatterer> wall;
  for (int beam = 0; beam < 64; ++beam) {
    for (int i = 0; i < 240; ++i) {
      Scatterer s;
      s.delay_s = two_way_delay_s(1.0 + i * 0.006, 1500);
      s.gain = 1;
      s.standard_deviation = 0.01f;
      s.beam = beam;
      s.key = beam * 1000 + i;
      wall.push_back(s);
    }
  }
  const ScattererList list = sorted_by_beam_and_delay(wall, 64);
  const auto backend = make_cpu_backend(setup);
  double power = 0, power2 = 0, clean = 0;
  int count = 0;
  for (std::uint32_t ping = 0; ping < 1500; ++ping) {
    RandomKeys keys;
    keys.speckle = stream_key(9, Stream::speckle, 0);
    keys.speckle_ping = ping;
    const PingSeries series = synthesize(*backend, list, keys);
    for (int beam = 2; beam < 64; beam += 12) {
      for (int n = 50; n < 90; n += 5) {
        const std::size_t at = std::size_t(beam) * setup.record.samples + n;
        const double intensity =
            std::norm(std::complex<double>(series.pressure_pa[at])) / series.clean_power_pa2[at];
        power += intensity;
        power2 += intensity * intensity;
        clean += series.clean_power_pa2[at];
        ++count;
      }
    }
  }
  const double mean = power / count;
  CHECK(clean > 0);
  CHECK(10 * std::log10(mean) == Approx(0).margin(0.05));
  const double contrast = std::sqrt(power2 / count - mean * mean) / mean;
  CHECK(contrast == Approx(1).margin(3 / std::sqrt(double(count))));
}
