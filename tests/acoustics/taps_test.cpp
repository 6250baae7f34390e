// Protects: responses as taps. Exact taps are found again; a smooth response is followed over the
// band; energies add.
#include "acoustics/taps.h"

#include <cmath>

#include "catch.h"

#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr double kCarrier = 750e3, kBand = 150e3;

Complex response_of(std::span<const Tap> taps, double f_hz) {
  Complex sum = 0;
  for (const Tap& tap : taps) sum += tap.gain * std::polar(1.0, -2 * kPi * f_hz * tap.delay_s);
  return sum;
}

// Largest error over the band, relative to the rms response.
double worst_error(const std::function<Complex(double)>& response, std::span<const Tap> taps) {
  double worst = 0, energy = 0;
  constexpr int kSteps = 200;
  for (int i = 0; i <= kSteps; ++i) {
    const double f = kCarrier + kBand * (double(i) / kSteps - 0.5);
    worst = std::max(worst, std::abs(response(f) - response_of(taps, f)));
    energy += std::norm(response(f)) / kSteps;
  }
  return worst / std::sqrt(energy);
}

}  // namespace

TEST_CASE("taps that lie on the grid are found exactly", "[acoustics]") {
  const std::vector<Tap> given = {{2 / kBand, {0.8, 0.1}}, {5.5 / kBand, {-0.2, 0.4}}};
  const auto taps = fit_taps([&](double f) { return response_of(given, f); },
                             {kCarrier, kBand, 0, 10 / kBand, 1e-9, 8});
  REQUIRE(taps.size() == 2);
  for (int i = 0; i < 2; ++i) {
    CHECK(std::abs(taps[i].delay_s - given[i].delay_s) * kBand < 1e-9);
    CHECK(std::abs(taps[i].gain - given[i].gain) < 1e-9);
  }
}

TEST_CASE("a resonance within the band is followed by its taps", "[acoustics]") {
  // A single pole of quality 10, which rings over 2/b.
  const auto pole = [](double f) { return 1.0 / (1.0 + Complex(0, 20) * (f / kCarrier - 1)); };
  const auto taps = fit_taps(pole, {kCarrier, kBand, -1 / kBand, 20 / kBand, 1e-3, 16});
  CHECK(worst_error(pole, taps) < 0.1);
  double energy = 0, sum = 0;
  for (const Tap& tap : taps) energy += std::norm(tap.gain);
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i) {
    sum += std::norm(pole(kCarrier + kBand * ((i + 0.5) / kSteps - 0.5))) / kSteps;
  }
  CHECK(std::abs(energy / sum - 1) < 0.1);
}

TEST_CASE("the product of taps is that of their responses", "[acoustics]") {
  const std::vector<Tap> a = {{1e-6, 0.5}, {9e-6, {0, 0.25}}}, b = {{2e-6, -1}, {7e-6, 0.5}};
  const auto both = product(a, b, 0);
  CHECK(both.size() == 4);
  for (const double f : {kCarrier - 6e4, kCarrier, kCarrier + 1e4}) {
    CHECK(std::abs(response_of(both, f) - response_of(a, f) * response_of(b, f)) < 1e-12);
  }
  CHECK(product(a, {}).empty());
  // Out and back through one wall, two of the delays are equal.
  const auto twice = product(a, a, 0);
  REQUIRE(twice.size() == 3);
  CHECK(std::abs(twice[1].gain - 2.0 * a[0].gain * a[1].gain) < 1e-12);
}

}  // namespace ensonify
