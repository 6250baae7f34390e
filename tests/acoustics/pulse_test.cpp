#include "acoustics/pulse.h"

#include <cmath>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

constexpr int kTransform = 2500;

// The envelope at time x samples, by its definition.
double envelope(const std::vector<std::complex<double>>& spectrum, double x) {
  const int count = static_cast<int>(spectrum.size());
  std::complex<double> sum = 0;
  for (int m = 0; m < count; ++m) {
    sum += spectrum[m] * std::polar(1.0, 2 * kPi * (m - count / 2) * x / count);
  }
  return std::abs(sum);
}

double db(double amplitude) { return 20 * std::log10(amplitude); }

// Where the envelope first falls through `level`, from the peak outward, by bisection.
double crossing(const std::vector<std::complex<double>>& spectrum, double level) {
  double low = 0, high = 2;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (envelope(spectrum, middle) > level ? low : high) = middle;
  }
  return low;
}

}  // namespace

// V3: range resolution and noise-equivalent length of the Gaussian pulse.
TEST_CASE("V3: the Gaussian pulse's width and energy") {
  const auto spectrum = pulse_spectrum(PulseShape::gaussian, kTransform);
  CHECK(envelope(spectrum, 0) == Approx(1).epsilon(1e-12));
  // Full width in metres at b = 29.9 kHz, c = 1500 m/s: samples times c / 2b.
  const double width_m = 2 * crossing(spectrum, std::sqrt(0.5)) * 1500 / (2 * 29.9e3);
  CHECK(width_m == Approx(0.0330).epsilon(0.01));
  // b int |s|^2 dt over one period, by Parseval: M sum |S|^2.
  double energy = 0;
  for (const auto& bin : spectrum) energy += std::norm(bin);
  CHECK(energy * kTransform == Approx(1.370).epsilon(0.01));
}

// Protects shadows and gaps behind strong echoes: side lobes of the tapered band.
TEST_CASE("the Gaussian pulse's side lobes") {
  const auto spectrum = pulse_spectrum(PulseShape::gaussian, kTransform);
  double highest = 0, place = 0;
  for (double x = 2.3; x < 200; x += 0.01) {
    const double s = envelope(spectrum, x);
    if (s > highest) highest = s, place = x;
    if (x > 10) CHECK(db(s) < -53 + 0.5);
    if (x > 20) CHECK(db(s) < -72 + 0.5);
    if (x > 30) CHECK(db(s) < -82 + 0.5);
  }
  CHECK(db(highest) == Approx(-32.4).margin(0.1));
  CHECK(place == Approx(2.9).margin(0.1));
}

TEST_CASE("the flat pulse is the tapered band alone") {
  const auto spectrum = pulse_spectrum(PulseShape::flat, 1000);
  const double middle = spectrum[500].real();
  CHECK(envelope(spectrum, 0) == Approx(1).epsilon(1e-12));
  CHECK(spectrum[100].real() == Approx(middle));         // -0.4 b
  CHECK(spectrum[50].real() == Approx(middle / 2));      // -0.45 b
  CHECK(spectrum[0].real() == Approx(0).margin(1e-15));  // -0.5 b
}

// Protects expected power: the Fourier series of |s|^2 is |s|^2.
TEST_CASE("the autospectrum gives the square of the envelope") {
  const auto spectrum = pulse_spectrum(PulseShape::gaussian, 90);
  const auto coefficients = pulse_autospectrum(spectrum);
  for (const double x : {0.0, 0.3, 1.7, 2.9, 44.9, 89.5}) {
    double square = coefficients[0].real();
    for (int k = 1; k < 90; ++k) {
      square += 2 * (coefficients[k] * std::polar(1.0, 2 * kPi * k * x / 90)).real();
    }
    const double s = envelope(spectrum, x);
    CHECK(square == Approx(s * s).margin(1e-12));
  }
}
