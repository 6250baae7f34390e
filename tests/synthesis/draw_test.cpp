#include "synthesis/draw.h"

#include "catch.h"

using namespace ensonify;

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
