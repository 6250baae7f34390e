// The closed forms of a point target, on either backend: what the series is worth in decibels,
// degrees and metres.
#include <algorithm>

#include "catch.h"
#include "synthesis/ping_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

std::unique_ptr<Backend> make_backend(bool reference, const SynthesisSetup& setup) {
  return reference ? make_reference_backend(setup) : make_cpu_backend(setup);
}

std::vector<std::complex<double>> row(const PingSeries& series, int samples, int beam) {
  const auto begin = series.pressure_pa.begin() + std::ptrdiff_t(beam) * samples;
  return {begin, begin + samples};
}

}  // namespace

// V1: SL - 40 log r + TS for a point target at a sector's centre, interpolated peak, 0.05 dB.
// V3: -3 dB width in range 0.0330 m.
TEST_CASE("V1, V3: level and range width of a point target") {
  const bool reference = GENERATE(true, false);
  const Sonar sonar = p900(reference ? 33 : 512, reference ? 33 * 90.0 / 512 : 90, 8);
  const SynthesisSetup setup = setup_of(sonar);
  const int beam = sonar.beam_count / 2;
  const ScattererList list =
      sorted_by_beam_and_delay({point_target(sonar, beam, 5.0, -40)}, sonar.beam_count);
  const PingSeries series = synthesize(*make_backend(reference, setup), list);
  const auto fine = interpolated(row(series, setup.record.samples, beam), 16);
  std::vector<double> power;
  for (const auto& p : fine) power.push_back(std::norm(p));
  const auto peak = std::max_element(power.begin(), power.end());
  CHECK(level_db(*peak) == Approx(152.04).margin(0.05));
  const double step_m = 1500 / (2 * sonar.bandwidth_hz * 16);
  CHECK(width_above(power, peak - power.begin(), *peak / 2) * step_m ==
        Approx(0.0330).epsilon(0.01));
  CHECK((peak - power.begin()) * step_m == Approx(5.0).margin(step_m));
}

// V2: -3 dB width 1.002 deg and first side lobe -13.26 dB of the azimuth cut.
TEST_CASE("V2: azimuth cut of a point target") {
  const Sonar sonar = p900(512, 90, 8);
  const SynthesisSetup setup = setup_of(sonar);
  const int beam = 256;
  // On a sample: 5 m is 199.33 samples, 199 of them 4.99164 m.
  const double range_m = sample_range_m(sonar, setup.water, 199);
  const ScattererList list =
      sorted_by_beam_and_delay({point_target(sonar, beam, range_m, -40)}, 512);
  const PingSeries series = synthesize(*make_cpu_backend(setup), list);
  std::vector<std::complex<double>> cut;
  for (int j = 0; j < 512; ++j) {
    cut.push_back(std::norm(row(series, setup.record.samples, j)[199]));
  }
  std::vector<double> fine;
  for (const auto& value : interpolated(cut, 16)) fine.push_back(value.real());
  const std::size_t peak = std::max_element(fine.begin(), fine.end()) - fine.begin();
  const double step_deg = 90.0 / 512 / 16;
  CHECK(width_above(fine, peak, fine[peak] / 2) * step_deg == Approx(1.002).epsilon(0.005));
  // Past the first null, at 1 / 0.884 deg, the next maximum is the first side lobe.
  const std::size_t null = peak + std::size_t(1.13 / step_deg);
  const double lobe = *std::max_element(fine.begin() + null, fine.begin() + null + 16 * 8);
  CHECK(10 * std::log10(lobe / fine[peak]) == Approx(-13.26).margin(0.1));
}

// Protects the carrier phase in the stored series: e^(-i 2 pi f_c tau) at the echo's peak.
TEST_CASE("the carrier phase stays in the series") {
  const Sonar sonar = p900(9, 9, 8);
  const SynthesisSetup setup = setup_of(sonar);
  const double range_m = sample_range_m(sonar, setup.water, 150);
  const ScattererList list = sorted_by_beam_and_delay({point_target(sonar, 4, range_m, -40)}, 9);
  const PingSeries series = synthesize(*make_cpu_backend(setup), list);
  const double turns = carrier_turns(900e3, two_way_delay_s(range_m, 1500));
  const std::complex<double> expected =
      std::polar(1e5 * 0.01 / (range_m * range_m), -2 * kPi * turns);
  const std::complex<double> obtained = row(series, setup.record.samples, 4)[150];
  CHECK(std::abs(obtained - expected) < 1e-6 * std::abs(expected));
}

// Protects the record's ends: an echo in the last sample shows below -90 dB in the first tenth.
TEST_CASE("the padded record keeps late echoes out of its beginning") {
  const bool reference = GENERATE(true, false);
  const Sonar sonar = p900(5, 5, 12);
  const SynthesisSetup setup = setup_of(sonar);
  const int n = setup.record.samples;
  const ScattererList list = sorted_by_beam_and_delay(
      {point_target(sonar, 2, sample_range_m(sonar, setup.water, n - 1), 0)}, 5);
  const auto echo = row(synthesize(*make_backend(reference, setup), list), n, 2);
  double early = 0;
  for (int i = 0; i < n / 10; ++i) early = std::max(early, std::abs(echo[i]));
  CHECK(20 * std::log10(early / std::abs(echo[n - 1])) < -90);
}

// V15: noise alone has the level NL + 10 log10 b. 512 x 319 samples: standard error 0.011 dB.
TEST_CASE("V15: noise alone") {
  const Sonar sonar = p900(512, 90, 8);
  const SynthesisSetup setup = setup_of(sonar);
  const double power = sonar.bandwidth_hz * mean_square_pa2(30);
  RandomKeys keys;
  keys.noise = stream_key(1, Stream::noise, 0);
  const ScattererList nothing = sorted_by_beam_and_delay({}, 512);
  const PingSeries series = synthesize(*make_cpu_backend(setup), nothing, keys, power);
  double sum = 0;
  for (const auto& p : series.pressure_pa) sum += std::norm(std::complex<double>(p));
  CHECK(level_db(sum / series.pressure_pa.size()) == Approx(74.76).margin(0.1));
  for (const float clean : series.clean_power_pa2) REQUIRE(clean == 0);
}
