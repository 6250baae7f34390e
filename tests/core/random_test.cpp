#include "core/random.h"

#include <cmath>
#include <complex>
#include <set>

#include "catch.h"

using namespace ensonify;

namespace {

void require_words(Philox4 obtained, std::uint32_t a, std::uint32_t b, std::uint32_t c,
                   std::uint32_t d) {
  CHECK(obtained.v[0] == a);
  CHECK(obtained.v[1] == b);
  CHECK(obtained.v[2] == c);
  CHECK(obtained.v[3] == d);
}

}  // namespace

// Protects every data set's identity: the generator is Philox 4x32-10 as its authors publish it
// (known-answer vectors of Random123).
TEST_CASE("Philox 4x32-10 gives the published answers") {
  require_words(philox4x32_10({{0, 0, 0, 0}}, 0), 0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8);
  require_words(philox4x32_10({{~0u, ~0u, ~0u, ~0u}}, ~0ull), 0x408f276d, 0x41c83b0e, 0xa20bc7c6,
                0x6d5451fd);
  require_words(
      philox4x32_10({{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}}, 0x299f31d0a4093822ull),
      0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1);
}

// Protects the speckle's statistics: E|xi|^2 = 1, circular, exponential intensity. 400,000 draws;
// the standard error of the mean intensity is 1/sqrt(n) = 0.0016, of E xi^2 (each part) 0.0011,
// of the second moment of intensity sqrt(24 - 4)/sqrt(n) = 0.0071. Tolerances are 3 of them.
TEST_CASE("complex normal draws are circular with unit power") {
  const int n = 400000;
  std::complex<double> first = 0, square = 0;
  double power = 0, power2 = 0;
  for (int i = 0; i < n; ++i) {
    const ComplexDraw draw = complex_normal(stream_key(11, Stream::speckle, 0), 3, i, 0);
    const std::complex<double> xi(draw.re, draw.im);
    first += xi;
    square += xi * xi;
    power += std::norm(xi);
    power2 += std::norm(xi) * std::norm(xi);
  }
  const double se = 1 / std::sqrt(double(n));
  CHECK(std::abs(first) / n < 3 * se);
  CHECK(std::abs(square) / n < 3 * std::sqrt(2.0) * se);
  CHECK(power / n == Approx(1).margin(3 * se));
  CHECK(power2 / n == Approx(2).margin(3 * std::sqrt(20.0) * se));
}

// Protects reproducible yet distinct draws: seed, stream, sequence, ping, item and draw each lead
// to other numbers, and seed 0 is a seed like any other.
TEST_CASE("every part of key and counter matters") {
  std::set<std::uint64_t> keys;
  for (std::uint64_t seed : {0ull, 1ull, ~0ull}) {
    for (const Stream stream : {Stream::speckle, Stream::noise, Stream::split}) {
      for (std::uint32_t sequence : {0u, 1u, 1000000u}) {
        keys.insert(stream_key(seed, stream, sequence));
      }
    }
  }
  CHECK(keys.size() == 27);
  const double u = uniform(5, 0, 0, 0);
  CHECK(u == uniform(5, 0, 0, 0));
  CHECK(u != uniform(5, 1, 0, 0));
  CHECK(u != uniform(5, 0, 1, 0));
  CHECK(u != uniform(5, 0, 1ull << 32, 0));
  CHECK(u != uniform(5, 0, 0, 1));
}
