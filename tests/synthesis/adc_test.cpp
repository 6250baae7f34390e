#include "synthesis/adc.h"

#include <cmath>
#include <limits>
#include <vector>

#include "catch.h"
#include "core/random.h"
#include "synthesis/draw.h"

using namespace ensonify;

namespace {

constexpr double kTwoPascal_db = 126.02059991327963;

// The real part after conversion, in pascal.
float converted(const Adc& adc, double pressure_pa) {
  std::complex<float> sample(static_cast<float>(pressure_pa), 0);
  quantise(adc, {&sample, 1});
  return sample.real();
}

}  // namespace

// Protects the step: full scale of 2 Pa in 3 bits is 4 steps of 0.5 Pa to either side of zero.
TEST_CASE("the converter rounds to its steps, ties to even") {
  const Adc adc{3, kTwoPascal_db};
  CHECK(converted(adc, 0.24) == 0);
  CHECK(converted(adc, 0.26) == Approx(0.5));
  CHECK(converted(adc, -0.76) == Approx(-1));
  // Steps of exactly a power of two in pascal, so that a tie is one: 120 dB is 1 Pa.
  const Adc whole{3, 120};
  CHECK(converted(whole, 0.125) == 0);
  CHECK(converted(whole, 0.375) == 0.5f);
  CHECK(converted(whole, 0.625) == 0.5f);
  CHECK(converted(whole, -0.125) == 0);
  CHECK(converted(whole, -0.375) == -0.5f);
}

// Protects two's complement's ends: one step less above than below.
TEST_CASE("the converter clips at both ends, each part on its own") {
  const Adc adc{3, 120};
  CHECK(converted(adc, 0.99) == 0.75f);
  CHECK(converted(adc, 7) == 0.75f);
  CHECK(converted(adc, -0.99) == -1.0f);
  CHECK(converted(adc, -7) == -1.0f);
  std::complex<float> sample(-9, 0.3f);
  quantise(adc, {&sample, 1});
  CHECK(sample == std::complex<float>(-1, 0.25f));
}

// Protects every width from 1 to 24: codes survive the float they are stored in, none leaves its
// range, and whatever is finite or infinite comes out as a number.
TEST_CASE("codes of 1 to 24 bits come back from the stored floats") {
  const float infinity = std::numeric_limits<float>::infinity();
  for (int bits = 1; bits <= 24; ++bits) {
    const Adc adc{bits, 170.3};
    const double steps = std::ldexp(1.0, bits - 1);
    const double step_pa = std::pow(10.0, (170.3 - 120) / 20) / steps;
    for (int i = 0; i < 1000; ++i) {
      const double code = i < 4 ? (i < 2 ? -steps + i : steps - 1 - (i - 2))
                                : std::rint((2 * uniform(32, 0, i, 0) - 1) * (steps - 1));
      const float stored = converted(adc, code * step_pa);
      const double expected = std::min(std::max(code, -steps), steps - 1);
      INFO("bits " << bits << " code " << code);
      REQUIRE(std::rint(stored / step_pa) == expected);
      REQUIRE(converted(adc, stored) == stored);
    }
    for (const float wild : {infinity, std::numeric_limits<float>::max()}) {
      REQUIRE(converted(adc, wild) == Approx((steps - 1) * step_pa));
      REQUIRE(converted(adc, -wild) == Approx(-steps * step_pa));
    }
    REQUIRE(converted(adc, std::numeric_limits<float>::denorm_min()) == 0);
  }
}

// Protects scatterers without a diffuse part from being drawn, and the mean from being lost.
TEST_CASE("an amplitude is its mean plus a keyed draw") {
  Scatterer s;
  s.mean = {0.25f, -0.5f};
  s.key = 77;
  RandomKeys keys;
  keys.speckle = 5;
  CHECK(draw_amplitude(s, keys) == s.mean);
  s.standard_deviation = 2;
  const ComplexDraw xi = complex_normal(5, 0, 77, 0);
  CHECK(draw_amplitude(s, keys).real() == Approx(0.25 + 2 * xi.re));
  CHECK(draw_amplitude(s, keys).imag() == Approx(-0.5 + 2 * xi.im));
  RandomKeys next = keys;
  next.speckle_ping = 1;
  CHECK(draw_amplitude(s, next) != draw_amplitude(s, keys));
}

// Protects volumes from sharing draws with the noise, and frozen speckle from moving in the water.
TEST_CASE("a volume's draw is keyed by cell and by the speckle's ping") {
  RandomKeys keys;
  keys.volume = 5;
  keys.noise = 6;
  const ComplexDraw xi = complex_normal(5, 0, (std::uint64_t{3} << 32) | 4, 0);
  CHECK(draw_volume(keys, 3, 4, 9).real() == Approx(3 * xi.re));
  CHECK(draw_volume(keys, 3, 4, 9).imag() == Approx(3 * xi.im));
  CHECK(draw_volume(keys, 3, 4, 0) == 0.0);
  CHECK(draw_volume(keys, 4, 3, 9) != draw_volume(keys, 3, 4, 9));
  CHECK(draw_volume(keys, 3, 4, 1) != draw_noise(keys, 3, 4, 1));
  RandomKeys next = keys;
  next.noise_ping = 1;
  CHECK(draw_volume(next, 3, 4, 9) == draw_volume(keys, 3, 4, 9));
  next.speckle_ping = 1;
  CHECK(draw_volume(next, 3, 4, 9) != draw_volume(keys, 3, 4, 9));
}

TEST_CASE("noise differs from sample to sample and from beam to beam") {
  RandomKeys keys;
  keys.noise = 5;
  CHECK(draw_noise(keys, 0, 0, 1) != draw_noise(keys, 0, 1, 1));
  CHECK(draw_noise(keys, 0, 1, 1) != draw_noise(keys, 1, 0, 1));
  CHECK(std::abs(draw_noise(keys, 3, 4, 4)) == Approx(2 * std::abs(draw_noise(keys, 3, 4, 1))));
}
