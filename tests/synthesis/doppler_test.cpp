// Echoes that come back shifted.
#include "synthesis/cpu/doppler_nodes.h"

#include "acoustics/pulse.h"
#include "catch.h"
#include "core/random.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/doppler_synthesis.h"
#include "synthesis/direct_sum.h"
#include "synthesis/v8.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

using Complex = std::complex<double>;

// Every third echo at rest, the others shifted by up to `most` to either side.
std::vector<Scatterer> shifted(std::vector<Scatterer> scatterers, double most) {
  for (std::size_t i = 0; i < scatterers.size(); ++i) {
    if (i % 3 == 0) continue;
    scatterers[i].doppler = static_cast<float>(most * (2 * uniform(71, 0, i, 0) - 1));
  }
  return scatterers;
}

Sonar with_cw(double duration_s, int beams, double range_max_m) {
  Sonar sonar = p900(beams, beams * 0.5, range_max_m);
  sonar.pulse.shape = PulseShape::cw;
  sonar.pulse.duration_s = duration_s;
  return sonar;
}

double relative_error(const PingSeries& obtained, const std::vector<Complex>& expected) {
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    error += std::norm(Complex(obtained.pressure_pa[i]) - expected[i]);
    norm += std::norm(expected[i]);
  }
  return std::sqrt(error / norm);
}

}  // namespace

// Protects the sign and size of the turn: within a burst the phase runs at f_c eta.
TEST_CASE("a shifted burst is a tone beside the carrier") {
  const Sonar sonar = with_cw(4e-3, 1, 8);
  const int bins = setup_of(sonar).record.transform;
  const DopplerPulse pulse = make_doppler_pulse(sonar, bins);
  CHECK(doppler_spectrum(pulse, 0) == pulse_spectrum(sonar, bins));
  for (const double eta : {-4e-3, -1e-3, 1e-3, 4e-3}) {
    const std::vector<Complex> spectrum = doppler_spectrum(pulse, eta);
    // Inside the burst, away from its ends, whose overtones the band cuts.
    for (const double t : {-1.6e-3, -0.7e-3, 0.0, 1e-3, 1.5e-3}) {
      Complex sum = 0;
      for (int m = 0; m < bins; ++m) {
        sum +=
            spectrum[m] * std::polar(1.0, 2 * kPi * (m - bins / 2) * t * sonar.bandwidth_hz / bins);
      }
      INFO("eta " << eta << " t " << t);
      const Complex tone = std::polar(1.0, 2 * kPi * sonar.frequency_hz * eta * t);
      CHECK(std::abs(sum / tone - std::abs(sum)) < 0.03);
      CHECK(std::abs(sum) == Approx(1).margin(0.12));
    }
  }
}

// The reference against a sum in the time domain: e^(i 2 pi f_c eta (t - tau)) s((1 + eta)(t -
// tau)) with s the unshifted pulse, which only the receiver's band sets apart.
TEST_CASE("the reference is the formula of a shifted echo") {
  const Sonar sonar = with_cw(3e-3, 1, 6);
  const SynthesisSetup setup = setup_of(sonar);
  const DirectSum direct(setup);
  Scatterer s = point_target(sonar, 0, 3.2, -20);
  s.doppler = 1.7e-3f;
  const PingSeries series =
      synthesize(*make_reference_backend(setup), sorted_by_beam_and_delay({s}, 1));
  std::vector<Complex> expected;
  for (int n = 0; n < setup.record.samples; ++n) {
    const double t = n / sonar.bandwidth_hz - s.delay_s, eta = static_cast<double>(s.doppler);
    const double turns = std::fmod(sonar.frequency_hz * s.delay_s, 1.0);
    expected.push_back(source_pressure_pa_m(sonar) * s.gain * static_cast<double>(s.mean.real()) *
                       std::polar(1.0, 2 * kPi * (sonar.frequency_hz * eta * t - turns)) *
                       direct.pulse((1 + eta) * t * sonar.bandwidth_hz));
  }
  CHECK(relative_error(series, expected) < 0.02);
}

// Frequency by the slope of the phase over the middle of a long burst: f_c eta within 1 %.
TEST_CASE("a long burst comes back at its shifted frequency") {
  const Sonar sonar = with_cw(10e-3, 1, 12);
  SynthesisSetup setup = setup_of(sonar);
  const double eta = GENERATE(-2e-3, 0.7e-3, 2e-3);
  setup.max_doppler = 2e-3;
  Scatterer s = point_target(sonar, 0, 6, -20);
  s.doppler = static_cast<float>(eta);
  const PingSeries series = synthesize(*make_cpu_backend(setup), sorted_by_beam_and_delay({s}, 1));
  const int middle = static_cast<int>(s.delay_s * sonar.bandwidth_hz);
  Complex turn = 0;
  for (int n = middle - 100; n < middle + 100; ++n) {
    turn += Complex(series.pressure_pa[n + 1]) * std::conj(Complex(series.pressure_pa[n]));
  }
  const double frequency = std::arg(turn) / (2 * kPi) * sonar.bandwidth_hz;
  CHECK(frequency == Approx(sonar.frequency_hz * eta).epsilon(0.01));
}

TEST_CASE("V8: shifts of every size and sign among echoes at rest", "[figure]") {
  const Sonar sonar = p900(24, 24, 6);
  require_agreement({.sonar = sonar,
                     .scatterers = shifted(random_scatterers(sonar, 500, 0.6, 21), 6e-3),
                     .judged_tenths = 9,
                     .tolerances = {1e-3, 1e-4, 1e-5, 1e-6, 1e-7},
                     .max_doppler = 6e-3});
}

// Protects pulses that the band cuts off: their nodes have no grid of the fast path.
TEST_CASE("V8: shifts that take pulses to the edge of the band and beyond") {
  const Sonar sonar = p900(6, 3, 5);
  std::vector<Scatterer> scatterers = random_scatterers(sonar, 60, 0.5, 27);
  for (Scatterer& s : scatterers)
    s.doppler = s.key % 5 == 0 ? 0.0f : s.key % 2 == 0 ? 1.3e-2f : 3e-2f;
  require_agreement({.sonar = sonar,
                     .scatterers = scatterers,
                     .judged_tenths = 9,
                     .tolerances = {1e-3, 1e-5, 1e-6},
                     .max_doppler = 3e-2});
}

// Protects echoes that share a beam cell and lie in different bands: approaching, receding and at
// rest, each in turn, and many of one kind between two of another.
TEST_CASE("V8: bands that take turns within a beam cell") {
  const Sonar sonar = p900(5, 2.5, 5);
  std::vector<Scatterer> scatterers = random_scatterers(sonar, 150, 0.5, 29);
  for (Scatterer& s : scatterers) {
    constexpr float kOf[] = {0, 4e-3f, -4e-3f, 1e-4f, -1e-4f};
    s.doppler = s.beam == 0 ? (s.key == 7 ? 4e-3f : -4e-3f) : kOf[s.key % 5];
  }
  require_agreement({.sonar = sonar,
                     .scatterers = scatterers,
                     .judged_tenths = 9,
                     .tolerances = {1e-3, 1e-5, 1e-6},
                     .max_doppler = 4e-3});
}

TEST_CASE("V8: shifted echoes of every pulse and window") {
  Sonar sonar = p900(4, 2, 5);
  sonar.pulse = pulse_of(GENERATE(PulseShape::flat, PulseShape::lfm, PulseShape::cw), sonar);
  sonar.window = GENERATE(Window::none, Window::hamming);
  require_agreement({.sonar = sonar,
                     .scatterers = shifted(random_scatterers(sonar, 100, 0.5, 25), 3e-3),
                     .judged_tenths = 9,
                     .tolerances = {1e-3, 1e-5, 1e-7},
                     .max_doppler = 3e-3});
}

TEST_CASE("V8: shifted echoes of a burst of 10 ms", "[figure]") {
  const Sonar sonar = with_cw(10e-3, 3, 12);
  require_agreement({.sonar = sonar,
                     .scatterers = shifted(random_scatterers(sonar, 15, 5, 26), 1e-3),
                     .judged_tenths = 9,
                     .tolerances = {1e-3, 1e-5, 1e-6},
                     .max_doppler = 1e-3});
}

// The tail of a strong shifted echo under faint ones, volumes and noise.
TEST_CASE("V8: a strong shifted echo at 1.5 m before a faint far field", "[figure]") {
  const double far_db = GENERATE(-40, -120);
  const Sonar sonar = p900(4, 2, 30);
  std::vector<Scatterer> scatterers = strong_before_faint(sonar, 20, 9, far_db);
  for (Scatterer& s : scatterers) s.doppler = s.key % 4 == 3 ? 0.0f : 1.1e-3f;
  require_agreement({.sonar = sonar,
                     .scatterers = scatterers,
                     .judged_tenths = 1,
                     .tolerances = {1e-4, 1e-5, 1e-6},
                     .max_doppler = 2e-3});
}

TEST_CASE("V8: shifted echoes with volumes and noise") {
  const Sonar sonar = p900(9, 4.5, 4);
  const std::vector<VolumeEcho> volumes = {
      volume_of(setup_of(sonar), [](int beam, int n) { return 1e-4 * beam / (1.0 + n * n); })};
  require_agreement({.sonar = sonar,
                     .scatterers = shifted(random_scatterers(sonar, 100, 0.5, 28), 2e-3),
                     .judged_tenths = 9,
                     .volumes = volumes,
                     .noise_power_pa2 = 1e-3,
                     .max_doppler = 2e-3});
}

// Protects old data sets: a backend that may shift leaves echoes at rest as they were.
TEST_CASE("echoes at rest are the same bytes whether or not others could be shifted") {
  const Sonar sonar = p900(40, 16, 3);
  SynthesisSetup setup = setup_of(sonar);
  setup.tolerance = GENERATE(1e-5, 1e-7);
  const ScattererList list =
      sorted_by_beam_and_delay(random_scatterers(sonar, 300, 0.4, 31), sonar.beam_count);
  const PingSeries still = synthesize(*make_cpu_backend(setup), list, keys_of_ping(1), 1e-3);
  setup.max_doppler = 1e-2;
  const PingSeries other = synthesize(*make_cpu_backend(setup), list, keys_of_ping(1), 1e-3);
  CHECK(still.pressure_pa == other.pressure_pa);
  CHECK(still.clean_power_pa2 == other.clean_power_pa2);
}

// Protects the layers: parts of a list add up to the whole far under the tolerance, because bands
// and nodes know nothing of the other scatterers. And threads, and pings after others.
TEST_CASE("shifted series are linear in the scatterers and do not depend on threads") {
  const Sonar sonar = p900(40, 16, 3);
  SynthesisSetup setup = setup_of(sonar);
  setup.tolerance = 1e-3;
  setup.max_doppler = 5e-3;
  const auto all = shifted(random_scatterers(sonar, 300, 0.4, 33), 5e-3);
  const auto backend = make_cpu_backend(setup);
  const auto series = [&](const auto& wanted) {
    std::vector<Scatterer> part;
    for (const Scatterer& s : all) {
      if (wanted(s)) part.push_back(s);
    }
    return synthesize(*backend, sorted_by_beam_and_delay(part, 40), keys_of_ping(1));
  };
  const PingSeries one = series([](const Scatterer& s) { return s.key % 4 == 0; });
  const PingSeries rest = series([](const Scatterer& s) { return s.key % 4 != 0; });
  const PingSeries whole = series([](const Scatterer&) { return true; });
  std::vector<Complex> sum;
  for (std::size_t i = 0; i < one.pressure_pa.size(); ++i) {
    sum.push_back(Complex(one.pressure_pa[i]) + Complex(rest.pressure_pa[i]));
  }
  CHECK(relative_error(whole, sum) < 1e-6);

  const ScattererList list = sorted_by_beam_and_delay(all, 40);
  for (const int threads : {1, 3}) {
    const PingSeries again =
        synthesize(*make_cpu_backend(setup), list, keys_of_ping(1), 0, {}, Workers(threads));
    CHECK(again.pressure_pa == whole.pressure_pa);
    CHECK(again.clean_power_pa2 == whole.clean_power_pa2);
  }
  std::vector<PingSeries> together(6);
  const auto fresh = make_cpu_backend(setup);
  Workers(3).for_each(6, [&](std::size_t i) {
    together[i] = synthesize(*fresh, list, keys_of_ping(1), 0, {}, Workers(1));
  });
  for (const PingSeries& each : together) CHECK(each.pressure_pa == whole.pressure_pa);
}

// Protects the speed: one run for each node takes as many times as long.
TEST_CASE("the fast path synthesizes shifted echoes in one run") {
  const Sonar sonar = p900(9, 4.5, 4);
  SynthesisSetup setup = setup_of(sonar);
  setup.max_doppler = 2e-3;
  SynthesisTables tables{
      setup, make_mixing(sonar), pulse_spectrum(sonar, setup.record.transform), {}};
  tables.autospectrum = pulse_autospectrum(tables.spectrum);
  int made = 0;
  const auto synthesis = make_doppler_synthesis(tables, [&](const SynthesisTables& own) {
    ++made;
    return make_fast_synthesis(own);
  });
  REQUIRE(synthesis);
  const ScattererList list =
      sorted_by_beam_and_delay(shifted(random_scatterers(sonar, 100, 0.5, 28), 2e-3), 9);
  PingTask task;
  task.scatterers = &list;
  PingSeries series;
  synthesis->run(task, series, Workers(2));
  CHECK(series.pressure_pa.size() == std::size_t(9) * setup.record.samples);
  CHECK(made == 1);
}

TEST_CASE("nodes of shifts interpolate polynomials and know where they are") {
  const DopplerNodes nodes{4, 2e-3};
  for (const double eta : {0.0, 1e-9, 7e-4, 2e-3, 3.1e-3, -1e-9, -2e-3, -5.5e-3}) {
    const DopplerWeights weights = weights_at(nodes, eta);
    double one = 0, cube = 0;
    for (int q = 0; q <= nodes.degree; ++q) {
      const double at = node_doppler(nodes, weights.first_node + weights.step * q);
      one += weights.value[q];
      cube += weights.value[q] * at * at * at;
      CHECK(std::abs(at - eta) <= 2e-3 * (1 + 1e-12));
    }
    CHECK(one == Approx(1).epsilon(1e-12));
    CHECK(cube == Approx(eta * eta * eta).epsilon(1e-9).margin(1e-21));
  }
}

TEST_CASE("which pulses can be shifted") {
  Sonar sonar = p900(4, 2, 5);
  CHECK(can_shift(setup_of(sonar)));
  sonar.pulse = pulse_of(PulseShape::table, sonar);
  CHECK_FALSE(can_shift(setup_of(sonar)));
}
