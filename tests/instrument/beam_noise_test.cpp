// Correlated noise: its power and covariance against those of the beam pattern.
#include "instrument/beam_noise.h"

#include <cmath>
#include <vector>

#include "acoustics/pattern.h"
#include "catch.h"
#include "sonar_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

using Samples = std::vector<std::complex<float>>;

Samples noise_of(const Sonar& sonar, int samples, std::uint32_t ping, double power_pa2) {
  Samples p(static_cast<std::size_t>(sonar.beam_count) * samples);
  BeamNoise(sonar).add(77, ping, power_pa2, samples, p, Workers());
  return p;
}

std::complex<double> covariance(const Samples& p, int samples, int a, int b) {
  std::complex<double> sum = 0;
  for (int n = 0; n < samples; ++n) {
    sum += std::complex<double>(p[std::size_t(a) * samples + n]) *
           std::conj(std::complex<double>(p[std::size_t(b) * samples + n]));
  }
  return sum / double(samples);
}

// sum_k B(i - k) B(j - k) over the cells of the fan, from the pattern itself.
double overlap(const Sonar& sonar, int i, int j) {
  double sum = 0;
  for (int k = 0; k < sonar.beam_count; ++k) {
    sum += line_pattern((i - k) * sonar.beam_spacing_rad, sonar.beam_width_rad) *
           line_pattern((j - k) * sonar.beam_spacing_rad, sonar.beam_width_rad);
  }
  return sum;
}

}  // namespace

TEST_CASE("beams share noise as their patterns overlap, and each keeps its power") {
  // Four beams in a beam width. The standard error of a covariance is power/sqrt(samples).
  const Sonar sonar = p900(24, 6, 10);
  constexpr int kSamples = 40000;
  constexpr double kPower = 2.5;
  const Samples p = noise_of(sonar, kSamples, 3, kPower);
  for (const auto& [i, j] : {std::pair{0, 0},
                             {12, 12},
                             {23, 23},
                             {12, 13},
                             {12, 14},
                             {12, 16},
                             {0, 1},
                             {5, 9},
                             {3, 20}}) {
    const double expected =
        kPower * overlap(sonar, i, j) / std::sqrt(overlap(sonar, i, i) * overlap(sonar, j, j));
    const std::complex<double> found = covariance(p, kSamples, i, j);
    INFO(i << " " << j << ": " << found << " against " << expected);
    CHECK(std::abs(found - expected) < 4 * kPower / std::sqrt(double(kSamples)));
  }
}

TEST_CASE("correlated noise is white in range and new in each ping") {
  const Sonar sonar = p900(8, 2, 10);
  constexpr int kSamples = 20000;
  const Samples one = noise_of(sonar, kSamples, 0, 1), other = noise_of(sonar, kSamples, 1, 1);
  std::complex<double> next = 0, ping = 0;
  for (int n = 0; n + 1 < kSamples; ++n) {
    next += std::complex<double>(one[n]) * std::conj(std::complex<double>(one[n + 1]));
    ping += std::complex<double>(one[n]) * std::conj(std::complex<double>(other[n]));
  }
  CHECK(std::abs(next) / kSamples < 4 / std::sqrt(double(kSamples)));
  CHECK(std::abs(ping) / kSamples < 4 / std::sqrt(double(kSamples)));
}

TEST_CASE("correlated noise of a sample does not depend on the length of the record") {
  const Sonar sonar = p900(8, 2, 10);
  const Samples whole = noise_of(sonar, 300, 0, 1), part = noise_of(sonar, 170, 0, 1);
  for (int beam = 0; beam < 8; ++beam) {
    for (int n = 0; n < 170; ++n) {
      CHECK(std::abs(whole[beam * 300 + n] - part[beam * 170 + n]) < 1e-6f);
    }
  }
}

// Isotropic noise has the same power per angle, not per beam cell: the covariance is the integral
// of both patterns over the fan.
TEST_CASE("unequal beams share noise as their patterns overlap") {
  Sonar sonar = p900(24, 6, 10);
  for (int j = 0; j < 24; ++j) {
    sonar.azimuth_rad.push_back(radians(0.15 * j + 0.006 * j * j - 3));
    sonar.width_rad.push_back(radians(0.8 + 0.03 * j));
  }
  const std::vector<double> borders = beam_borders_rad(sonar);
  sonar.beam_spacing_rad = (borders.back() - borders.front()) / 24;
  const auto integral = [&](int i, int j) {
    constexpr int kSteps = 2000;
    double sum = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double at = borders.front() + (k + 0.5) / kSteps * (borders.back() - borders.front());
      sum += line_pattern(at - sonar.azimuth_rad[i], sonar.width_rad[i]) *
             line_pattern(at - sonar.azimuth_rad[j], sonar.width_rad[j]);
    }
    return sum;
  };
  constexpr int kSamples = 40000;
  constexpr double kPower = 2.5;
  const Samples p = noise_of(sonar, kSamples, 3, kPower);
  for (const auto& [i, j] :
       {std::pair{0, 0}, {23, 23}, {12, 13}, {12, 14}, {0, 1}, {0, 3}, {21, 23}, {5, 9}}) {
    const double expected = kPower * integral(i, j) / std::sqrt(integral(i, i) * integral(j, j));
    const std::complex<double> found = covariance(p, kSamples, i, j);
    INFO(i << " " << j << ": " << found << " against " << expected);
    CHECK(std::abs(found - expected) < 4 * kPower / std::sqrt(double(kSamples)) + 0.01 * kPower);
  }
}
