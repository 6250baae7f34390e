#include "labels/elevation.h"

#include <cmath>

#include "catch.h"
#include "core/random.h"
#include "polar_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr double kStep_rad = 0.01, kCarrier_hz = 30000;

const Sonar kSonar = [] {
  Sonar sonar;
  sonar.frequency_hz = kCarrier_hz;
  sonar.bandwidth_hz = kMeterBandwidth_hz;
  return sonar;
}();

std::vector<ElevationEcho> entries_of(std::vector<Scatterer> echoes, int beams,
                                      std::span<const ElevationEcho> volumes = {},
                                      int threads = 2) {
  const ScattererList list = sorted_by_beam_and_delay(std::move(echoes), beams);
  return elevation_echoes({list, volumes, kSonar, 10, kStep_rad}, Workers(threads));
}

}  // namespace

// Protects the coordinates: ranges are those of the nearest sample, before the record too, steps
// begin at elevation 0 on both sides, and powers are S0^2 gain^2 times variance and |mean|^2.
TEST_CASE("an echo over elevation has the nearest sample, its offset, step and powers") {
  Scatterer glint = direct_echo(1, 7.75, 5, 0, -1e-9);
  glint.mean = {0.3f, 0.4f};
  const auto entries = entries_of(
      {direct_echo(0, 7.25, 4, 3, 0.0199), direct_echo(0, -0.75, 4, 2, -0.0301), glint}, 2);
  REQUIRE(entries.size() == 3);
  CHECK(entries[0].sample == -1);
  CHECK(entries[0].offset == Approx(0.25));
  CHECK(entries[0].step == -4);
  CHECK(entries[0].diffuse_pa2 == Approx(200));
  CHECK(entries[1].sample == 7);
  CHECK(entries[1].offset == Approx(0.25));
  CHECK(entries[1].step == 1);
  CHECK(entries[1].instance == 4);
  CHECK(entries[1].coherent_pa == 0.0f);
  CHECK(entries[2].beam == 1);
  CHECK(entries[2].sample == 8);
  CHECK(entries[2].offset == Approx(-0.25));
  CHECK(entries[2].step == -1);
  CHECK(entries[2].diffuse_pa2 == 0);
  // S0 gain mean e^(-i 2 pi f_c delay), with 310 turns of the carrier.
  CHECK(entries[2].coherent_pa.real() == Approx(10 * 2 * 0.3));
  CHECK(entries[2].coherent_pa.imag() == Approx(10 * 2 * 0.4));
}

// Protects what is added up: only echoes of one step, surface and path within a 128th of a sample,
// with their mean delay by power. Half a sample before n belongs to n.
TEST_CASE("echoes of one 128th of a sample, step, surface and path are one entry") {
  const double part = 1.0 / 128;
  Scatterer ghost = direct_echo(0, 5 + 0.2 * part, 4, 1);
  ghost.path = 1;
  const auto entries =
      entries_of({direct_echo(0, 5 + 0.2 * part, 4, 1), direct_echo(0, 5 + 0.6 * part, 4, 3), ghost,
                  direct_echo(0, 5 + 0.4 * part, 5, 1), direct_echo(0, 5 + 0.4 * part, 4, 1, 0.011),
                  direct_echo(0, 5 + 1.4 * part, 4, 1), direct_echo(0, 5.5, 4, 1),
                  direct_echo(0, 5.4999, 4, 1), direct_echo(0, 9, 4, 0)},
                 1);
  REQUIRE(entries.size() == 7);
  // By sample, step, offset.
  CHECK(entries[0].path == 1);
  CHECK(entries[1].instance == 5);
  CHECK(entries[2].offset == Approx(0.5 * part));
  CHECK(entries[2].diffuse_pa2 == Approx(400));
  CHECK(entries[3].offset == Approx(1.4 * part));
  CHECK(entries[4].sample == 5);
  CHECK(entries[4].offset == Approx(0.4999));
  CHECK(entries[5].step == 1);
  CHECK(entries[6].sample == 6);
  CHECK(entries[6].offset == Approx(-0.5));
}

// Protects glints, whose pieces cancel: pressures add with the phase of the carrier, which half a
// turn reverses, and the entry keeps its place.
TEST_CASE("pressures of fixed amplitudes add with their phases") {
  const double half_turn = 0.5 * kMeterBandwidth_hz / kCarrier_hz;  // 1/80 of a sample
  Scatterer one = direct_echo(0, 5, 4, 0), other = direct_echo(0, 5 + half_turn, 4, 0);
  one.mean = other.mean = 1;
  const auto apart = entries_of({one, other}, 1);
  REQUIRE(apart.size() == 2);
  CHECK(apart[0].coherent_pa.real() == Approx(20));
  CHECK(apart[1].coherent_pa.real() == Approx(-20));
  other.delay_s = one.delay_s;
  other.mean = -0.75f;
  other.key = 1;
  const auto together = entries_of({one, other}, 1);
  REQUIRE(together.size() == 1);
  CHECK(together[0].coherent_pa.real() == Approx(5));
  CHECK(together[0].offset == Approx(0).margin(1e-6));
}

// Protects against lost echoes, and against an order that depends on threads: the powers of many
// random echoes and volumes add up beam by beam.
TEST_CASE("all power of a ping is in its echoes over elevation, in a fixed order") {
  std::vector<Scatterer> echoes;
  std::vector<double> power(9);
  for (std::uint32_t i = 0; i < 4000; ++i) {
    const auto draw = [&](std::uint32_t what) { return uniform(7, 1, i, what); };
    const auto beam = static_cast<std::uint32_t>(draw(0) * 9);
    echoes.push_back(direct_echo(beam, draw(1) * 40 - 3,
                                 1 + static_cast<std::uint32_t>(draw(2) * 2), draw(3),
                                 0.3 * (draw(4) - 0.5)));
    echoes.back().key = i;
    power[beam] += 100 * 4 * std::pow(double{echoes.back().standard_deviation}, 2);
  }
  std::vector<ElevationEcho> volumes;
  for (std::uint16_t beam = 2; beam < 5; ++beam) {
    volumes.push_back({.sample = 3, .beam = beam, .step = 1, .diffuse_pa2 = 50, .instance = 9});
    power[beam] += 50;
  }
  const auto entries = entries_of(echoes, 9, volumes);
  std::vector<double> found(9);
  for (const ElevationEcho& entry : entries) found[entry.beam] += entry.diffuse_pa2;
  for (int beam = 0; beam < 9; ++beam) CHECK(found[beam] == Approx(power[beam]).epsilon(1e-6));
  const auto other = entries_of(echoes, 9, volumes, 1);
  REQUIRE(other.size() == entries.size());
  bool same = true;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    same = same && entries[i].sample == other[i].sample && entries[i].step == other[i].step &&
           entries[i].offset == other[i].offset && entries[i].diffuse_pa2 == other[i].diffuse_pa2;
    if (i == 0) continue;
    const auto& before = entries[i - 1];
    same = same && (before.beam < entries[i].beam ||
                    (before.beam == entries[i].beam && before.sample <= entries[i].sample));
  }
  CHECK(same);
}
