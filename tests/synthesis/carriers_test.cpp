// Groups of beams with carriers of their own.
#include "synthesis/carriers.h"

#include <cmath>
#include <complex>
#include <vector>

#include "acoustics/pulse.h"
#include "catch.h"
#include "synthesis/ping_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// Two sectors of one beam each, both with the whole patch in their main lobes.
Sonar two_sectors(double offset_hz) {
  Sonar sonar = p900(2, 0.2, 40);
  sonar.beam_width_rad = radians(20);
  sonar.pulse.shape = PulseShape::flat;
  const double f = sonar.frequency_hz;
  sonar.transmit = TransmitGroups{
      .count = 2, .sector_beams = {1, 1}, .frequency_hz = {f, f + offset_hz}, .order = {0, 1}};
  return sonar;
}

// In the cell of beam 0, with unit variance at the receiver.
ScattererList even_patch(const Sonar& sonar, const SynthesisSetup& setup) {
  constexpr int kPerSample = 12;
  std::vector<Scatterer> items;
  for (int i = 0; i < kPerSample * setup.record.samples; ++i) {
    Scatterer s = point_target(sonar, 0, 1, 0);
    s.delay_s = (i + 0.37) / kPerSample * setup.record.sample_interval_s;
    s.gain = 1;
    s.mean = 0;
    s.standard_deviation = 1;
    s.key = static_cast<std::uint64_t>(i);
    items.push_back(s);
  }
  return sorted_by_beam_and_delay(std::move(items), 2);
}

}  // namespace

// Protects that each sector hears the same scatterers at its own carrier: with one carrier, the two
// would be fully correlated at every offset, with separate amplitudes at none.
TEST_CASE("speckle of one patch in two sectors decorrelates with their frequencies as (18c)") {
  for (const double share : {0.0, 0.25, 0.6, 1.0}) {
    CAPTURE(share);
    const SynthesisSetup alone = setup_of(two_sectors(0));
    const auto bins = static_cast<std::size_t>(std::lround(share * alone.record.transform));
    const double offset_hz =
        static_cast<double>(bins) * alone.sonar.bandwidth_hz / alone.record.transform;
    const Sonar sonar = two_sectors(offset_hz);
    const SynthesisSetup setup = setup_of(sonar);
    const auto backend = make_carrier_backend(setup, make_cpu_backend);
    const ScattererList patch = even_patch(sonar, setup);
    const int samples = setup.record.samples;
    std::complex<double> both = 0;
    double a = 0, b = 0, count = 0;
    for (std::uint32_t ping = 0; ping < 4; ++ping) {
      const PingSeries series = synthesize(*backend, patch, keys_of_ping(ping));
      for (int n = 50; n < samples - 50; ++n) {
        const auto p = std::complex<double>(series.pressure_pa[n]),
                   q = std::complex<double>(series.pressure_pa[samples + n]);
        const double turns = offset_hz * n * setup.record.sample_interval_s;
        both += q * std::conj(p) * std::polar(1.0, 2 * kPi * turns);
        a += std::norm(p);
        b += std::norm(q);
        ++count;
      }
    }
    // Samples of a flat pulse are independent.
    const std::complex<double> found = both / std::sqrt(a * b);
    const auto spectrum = pulse_spectrum(sonar, setup.record.transform);
    double shared = 0, all = 0;
    for (std::size_t m = 0; m < spectrum.size(); ++m) {
      all += std::norm(spectrum[m]);
      if (m >= bins) shared += std::real(spectrum[m] * std::conj(spectrum[m - bins]));
    }
    const double expected = shared / all;
    CHECK(std::abs(found - expected) < 4 * std::sqrt((1 - expected * expected) / count) + 0.005);
  }
}

TEST_CASE("echoes get the absorption of the group that hears them") {
  const Sonar sonar = two_sectors(2 * p900(2, 0.2, 40).bandwidth_hz);
  SynthesisSetup setup = setup_of(sonar);
  setup.water.absorption_db_m = 0.1;
  setup.water.group_absorption_db_m = {0.1, 0.4};
  const auto series_of = [&](const SynthesisSetup& of) {
    const ScattererList list = sorted_by_beam_and_delay({point_target(sonar, 0, 20, 0)}, 2);
    return synthesize(*make_carrier_backend(of, make_cpu_backend), list, keys_of_ping(0));
  };
  const PingSeries own = series_of(setup);
  setup.water.group_absorption_db_m.clear();
  const PingSeries same = series_of(setup);
  const auto n =
      static_cast<std::size_t>(std::lround(40 / setup.water.sound_speed_m_s * sonar.bandwidth_hz));
  const std::size_t other = static_cast<std::size_t>(setup.record.samples) + n;
  CHECK(own.pressure_pa[n] == same.pressure_pa[n]);
  const double ratio = std::abs(std::complex<double>(own.pressure_pa[other]) /
                                std::complex<double>(same.pressure_pa[other]));
  CHECK(20 * std::log10(ratio) == Approx(-0.3 * 40).margin(1e-3));
  VolumeEcho volume{1, std::vector<float>(2 * n + 2, 1), {}, {}};
  absorb(volume, sonar, setup.water, more_absorption_db_m(sonar, [&] {
           Water water = setup.water;
           water.group_absorption_db_m = {0.1, 0.4};
           return water;
         }()));
  CHECK(volume.energy[n] == 1);
  const double path_m = 2 * sample_range_m(sonar, setup.water, static_cast<int>(n));
  CHECK(10 * std::log10(double{volume.energy[2 * n + 1]}) == Approx(-0.3 * path_m).margin(1e-4));
}
