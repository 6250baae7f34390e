#include "bench/plain.h"

#include <cmath>
#include <numeric>
#include <string>

#include "catch.h"
#include "synthesis/draw.h"
#include "synthesis/ping_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

struct Ping {
  SynthesisSetup setup;
  ScattererList list;
  std::vector<std::complex<float>> amplitude;
  PingSeries reference;
};

Ping small_ping(Normalization normalization) {
  Sonar sonar = p900(24, 24, 5);
  sonar.normalization = normalization;
  Ping ping;
  ping.setup = setup_of(sonar);
  ping.list = sorted_by_beam_and_delay(random_scatterers(sonar, 120, 1, 3), sonar.beam_count);
  const RandomKeys keys = keys_of_ping(2);
  for (const Scatterer& s : ping.list.items) ping.amplitude.push_back(draw_amplitude(s, keys));
  ping.reference = synthesize(*make_reference_backend(ping.setup), ping.list, keys);
  return ping;
}

std::vector<std::complex<double>> widened(const std::vector<std::complex<float>>& series) {
  return {series.begin(), series.end()};
}

}  // namespace

// Protects the comparison: the plain methods compute what the backends do, pulse, mixing, carrier
// and all.
TEST_CASE("the plain methods agree with the reference backend") {
  const Workers workers(2);
  for (const auto normalization : {Normalization::calibrated, Normalization::mean_square}) {
    const Ping ping = small_ping(normalization);
    const int beams = ping.setup.sonar.beam_count;
    std::vector<int> all(beams);
    std::iota(all.begin(), all.end(), 0);
    const KernelList levels = supported_kernels();
    for (int level = 0; level < levels.count; ++level) {
      INFO(levels.table[level]->level);
      for (const RaySum method : {RaySum::direct, RaySum::recurrence}) {
        PlainMethod plain(ping.setup, *levels.table[level]);
        std::vector<std::complex<float>> series;
        plain.ray_sum(method, ping.list, ping.amplitude, all, workers);
        plain.mix(workers);
        plain.transform(series, workers);
        CHECK(series_error(series, widened(ping.reference.pressure_pa), beams).relative < 1e-5);
      }
    }
  }
}

// Protects the reported error of the backends; 1e-7 is the rounding of the reference's own result.
TEST_CASE("the exact series is the reference backend's") {
  const Workers workers(2);
  for (const auto normalization : {Normalization::calibrated, Normalization::mean_square}) {
    const Ping ping = small_ping(normalization);
    const auto exact = exact_series(
        ping.setup, exact_spectra(ping.setup, ping.list, ping.amplitude, best_kernels(), workers),
        workers);
    const SeriesError error =
        series_error(ping.reference.pressure_pa, exact, ping.setup.sonar.beam_count);
    CHECK(error.relative < 1e-7);
    CHECK(error.worst_tenth < 1e-7);
  }
}

// 100 samples of one beam: 1 in the first half, 1e-3 in the second but for the last tenth, which is
// too faint to be judged.
TEST_CASE("errors are relative to the record and to its tenths") {
  std::vector<std::complex<double>> exact(100, 1.0);
  for (int n = 50; n < 100; ++n) exact[n] = n < 90 ? 1e-3 : 1e-9;
  std::vector<std::complex<float>> series(exact.begin(), exact.end());
  CHECK(series_error(series, exact, 1).relative < 1e-7);
  for (int n = 60; n < 70; ++n) series[n] = {1e-3f, 1e-5f};
  for (int n = 90; n < 100; ++n) series[n] = 1e-7f;
  const SeriesError error = series_error(series, exact, 1);
  CHECK(error.relative == Approx(1e-5 * std::sqrt(10.0 / 50)).epsilon(1e-3));
  CHECK(error.worst_tenth == Approx(1e-2).epsilon(1e-3));
}
