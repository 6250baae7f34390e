#include "labels/polar.h"

#include <cmath>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

constexpr double kBandwidth_hz = 1000;  // a sample a millisecond

Scatterer echo(std::uint32_t beam, double sample, std::uint32_t instance, double energy,
               double elevation_rad = 0) {
  Scatterer s;
  s.beam = beam;
  s.delay_s = sample / kBandwidth_hz;
  s.instance = instance;
  s.gain = 2;
  s.standard_deviation = static_cast<float>(std::sqrt(energy) / 2);
  s.arrival.elevation_rad = static_cast<float>(elevation_rad);
  s.position_m = {0.75 * sample, 0, 0};
  return s;
}

struct Scene {
  ScattererList list;
  std::vector<std::complex<float>> pressure;
  std::vector<float> clean;
  std::vector<std::uint8_t> classes{0, 5, 6, 5};
  PolarInput input;

  Scene(std::vector<Scatterer> echoes, int beams, int samples, double noise_power = 0)
      : list(sorted_by_beam_and_delay(std::move(echoes), beams)),
        pressure(std::size_t(beams) * samples, {1e-3f, 0}),
        clean(std::size_t(beams) * samples, 1e-6f) {
    input.scatterers = &list;
    input.pressure_pa = pressure;
    input.clean_power_pa2 = clean;
    input.noise_power_pa2 = noise_power;
    input.bandwidth_hz = kBandwidth_hz;
    input.beams = beams;
    input.samples = samples;
    input.class_of_instance = classes;
  }
  LabelledImage image() const { return polar_image(input, Workers(2)); }
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
