#include "labels/polar.h"

#include <cmath>

#include "catch.h"
#include "core/units.h"
#include "polar_fixture.h"

using namespace ensonify;

namespace {

constexpr double kPolarBandwidth_hz = 1000;  // a sample a millisecond

Scatterer echo(std::uint32_t beam, double sample, std::uint32_t instance, double energy,
               double elevation_rad = 0) {
  Scatterer s;
  s.beam = beam;
  s.delay_s = sample / kPolarBandwidth_hz;
  s.instance = instance;
  s.gain = 2;
  s.standard_deviation = static_cast<float>(std::sqrt(energy) / 2);
  s.arrival.elevation_rad = static_cast<float>(elevation_rad);
  s.position_m = {0.75 * sample, 0, 0};
  return s;
}

VolumeEcho empty_volume(std::uint32_t instance, int cells) {
  VolumeEcho volume;
  volume.instance = instance;
  volume.energy.resize(cells);
  volume.elevation_rad.resize(cells);
  volume.elevation_square.resize(cells);
  return volume;
}

struct Scene : test::PolarPing {
  Scene(std::vector<Scatterer> echoes, int beams, int samples, double noise_power = 0)
      : PolarPing(std::move(echoes), beams, samples, kPolarBandwidth_hz, {0, 5, 6, 5}) {
    input.noise_power_pa2 = noise_power;
  }
  std::vector<std::uint8_t> hears() const {
    return hears_echo(list, volumes, kPolarBandwidth_hz, input.beams, input.samples);
  }
};

}  // namespace

// Protects the reach of an echo: samples within one of its own, in its own sector alone.
TEST_CASE("an echo labels the samples within one of it") {
  const LabelledImage image = Scene({echo(1, 4.25, 1, 1), echo(1, 8, 2, 1)}, 3, 12).image();
  for (int n = 0; n < 12; ++n) {
    const int expected = n == 4 || n == 5 ? 1 : (n >= 7 && n <= 9 ? 2 : 0);
    INFO("sample " << n);
    CHECK(image.instance[n * 3 + 1] == expected);
    CHECK(image.instance[n * 3 + 0] == 0);
    CHECK(image.instance[n * 3 + 2] == 0);
    CHECK(image.semantic[n * 3 + 1] == (expected == 0 ? 0 : expected == 1 ? 5 : 6));
    CHECK(std::isnan(image.elevation_rad[n * 3 + 1]) == (expected == 0));
  }
}

// Protects the winner: most energy summed over its echoes, ties to the lower id.
TEST_CASE("the instance with most energy wins") {
  const LabelledImage sum =
      Scene({echo(0, 5, 1, 3), echo(0, 5.1, 2, 2), echo(0, 4.9, 2, 2)}, 1, 10).image();
  CHECK(sum.instance[5] == 2);
  CHECK(sum.instance_fraction[5] == Approx(4.0 / 7));
  const LabelledImage tie = Scene({echo(0, 5, 3, 1), echo(0, 5, 2, 1)}, 1, 10).image();
  CHECK(tie.instance[5] == 2);
  CHECK(tie.instance_fraction[5] == Approx(0.5));
}

TEST_CASE("elevation is the energy-weighted mean with its spread") {
  const LabelledImage image = Scene({echo(0, 5, 1, 1, 0.1), echo(0, 5, 2, 3, -0.1)}, 1, 10).image();
  CHECK(image.elevation_rad[5] == Approx(-0.05));
  CHECK(image.elevation_std_rad[5] == Approx(std::sqrt(0.25 * 0.15 * 0.15 + 0.75 * 0.05 * 0.05)));
  CHECK(std::isnan(image.elevation_std_rad[0]));
}

// Protects labels from echoes that nobody could see.
TEST_CASE("noise hides instances but not elevation") {
  Scene scene({echo(0, 5, 1, 1)}, 1, 10, 2e-6);
  scene.clean[4] = 3e-6f;
  const LabelledImage image = scene.image();
  CHECK(image.instance[4] == 1);
  CHECK(image.instance[5] == 0);
  CHECK(image.instance_fraction[5] == 0);
  CHECK_FALSE(std::isnan(image.elevation_rad[5]));
}

// Protects the weights of a volume's cells, up to the record's ends, and its sector.
TEST_CASE("a volume counts with its own cell and half of those beside it") {
  Scene scene({echo(1, 5, 1, 2.5)}, 2, 10);
  scene.volumes = {empty_volume(3, 20)};
  scene.volumes[0].energy[10 + 4] = 3;
  scene.volumes[0].energy[10 + 5] = 1;
  scene.volumes[0].energy[10 + 9] = 1;
  const LabelledImage image = scene.image();
  const auto at = [](int n) { return n * 2 + 1; };
  CHECK(image.instance[at(3)] == 3);  // half of cell 4 alone
  CHECK(image.instance_fraction[at(3)] == Approx(1));
  CHECK(image.instance[at(4)] == 3);  // 3 + 1/2 against 2.5
  CHECK(image.instance_fraction[at(4)] == Approx(3.5 / 6));
  CHECK(image.instance[at(5)] == 1);  // 1 + 3/2 against 2.5: a tie
  CHECK(image.instance_fraction[at(5)] == Approx(0.5));
  CHECK(image.instance[at(6)] == 1);  // 1/2 against 2.5
  CHECK(image.instance_fraction[at(6)] == Approx(2.5 / 3));
  CHECK(image.instance[at(7)] == 0);
  CHECK(image.instance[at(8)] == 3);
  CHECK(image.instance[at(9)] == 3);
  CHECK(image.semantic[at(9)] == 5);
  for (int n = 0; n < 10; ++n) CHECK(image.instance[n * 2] == 0);
}

// Protects volumes of one kind from being cells of one another: each wins with its own energy.
TEST_CASE("volumes compete with each other by instance") {
  Scene scene({}, 1, 5);
  scene.volumes = {empty_volume(2, 5), empty_volume(3, 5)};
  scene.volumes[0].energy = {0, 2, 0, 2, 0};
  scene.volumes[1].energy = {0, 0, 1.5f, 0, 0};
  const LabelledImage image = scene.image();
  CHECK(image.instance[2] == 2);  // 1 + 1 against 1.5
  CHECK(image.instance_fraction[2] == Approx(2 / 3.5));
  CHECK(image.semantic[2] == 6);
}

// Protects the spread inside a cell, which its mean does not show, and empty cells of a volume from
// lending their elevation.
TEST_CASE("elevation takes in a volume's mean and spread") {
  Scene scene({echo(0, 5, 1, 1, 0.1)}, 1, 10);
  scene.volumes = {empty_volume(2, 10)};
  VolumeEcho& water = scene.volumes[0];
  water.energy[5] = 2;
  water.elevation_rad[5] = -0.05f;
  water.elevation_square[5] = 0.0125f;
  water.energy[6] = 2;
  water.elevation_rad[6] = 0.02f;
  water.elevation_square[6] = 0.0004f;
  water.elevation_rad[4] = std::nanf("");
  const LabelledImage image = scene.image();
  // Energies 1, 2 and 1 (half of cell 6).
  const double mean = (0.1 - 2 * 0.05 + 0.02) / 4;
  const double square = (0.01 + 2 * 0.0125 + 0.0004) / 4;
  CHECK(image.elevation_rad[5] == Approx(mean));
  CHECK(image.elevation_std_rad[5] == Approx(std::sqrt(square - mean * mean)));
  CHECK(image.elevation_rad[7] == Approx(0.02));
  CHECK(image.elevation_std_rad[7] == Approx(0).margin(1e-5));
  CHECK(std::isnan(image.elevation_rad[8]));
}

TEST_CASE("noise hides volumes but not their elevation") {
  Scene scene({}, 1, 5, 2e-6);
  scene.volumes = {empty_volume(1, 5)};
  scene.volumes[0].energy = {1, 1, 1, 1, 1};
  scene.clean[3] = 3e-6f;
  const LabelledImage image = scene.image();
  CHECK(image.instance[2] == 0);
  CHECK_FALSE(std::isnan(image.elevation_rad[2]));
  CHECK(image.instance[3] == 1);
}

// Protects the noise that is set by the echoes' level: a pixel hears just where it has a label
// without noise, and echoes without energy are none.
TEST_CASE("a pixel hears an echo where it has an elevation") {
  Scene scene({echo(0, 4.25, 1, 1), echo(1, 8, 2, 1), echo(2, 3, 1, 0)}, 3, 12, 1);
  scene.volumes = {empty_volume(3, 36)};
  scene.volumes[0].energy[1 * 12 + 2] = 1e-6f;
  const LabelledImage image = scene.image();
  const std::vector<std::uint8_t> hears = scene.hears();
  REQUIRE(hears.size() == 36);
  int count = 0;
  for (int beam = 0; beam < 3; ++beam) {
    for (int n = 0; n < 12; ++n) {
      INFO("beam " << beam << " sample " << n);
      CHECK(hears[beam * 12 + n] == !std::isnan(image.elevation_rad[n * 3 + beam]));
      count += hears[beam * 12 + n];
    }
  }
  CHECK(count == 2 + 3 + 3);
  CHECK(hears[4] == 1);
  CHECK(hears[3] == 0);
  CHECK(hears[12 + 3] == 1);
}

TEST_CASE("levels are transposed to samples by beams") {
  Scene scene({}, 2, 3);
  scene.pressure[1 * 3 + 2] = {0, 1};
  scene.clean[0 * 3 + 1] = 0;
  const LabelledImage image = scene.image();
  CHECK(image.rows == 3);
  CHECK(image.columns == 2);
  CHECK(image.level_db[2 * 2 + 1] == Approx(120));
  CHECK(image.level_db[0] == Approx(60));
  CHECK(image.clean_db[1 * 2 + 0] == kNoEnergyDb);
}

TEST_CASE("first return is the nearest echo of a sector") {
  const ScattererList list = sorted_by_beam_and_delay({echo(2, 9, 1, 1), echo(2, 4, 2, 1)}, 3);
  const std::vector<float> first = first_return_m(list, 3);
  CHECK(std::isnan(first[0]));
  CHECK(first[2] == Approx(3));
}
