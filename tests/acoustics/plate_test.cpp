// Protects: what a plate reflects and lets through. Three-layer matrices at normal incidence, the
// fluid plate at any angle, energy, the mass law, air inside, and the taps of the whole response.
#include "acoustics/plate.h"

#include <cmath>
#include <random>

#include "catch.h"
#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

const Water kWater{.sound_speed_m_s = 1480, .density_kg_m3 = 1000};
const Wall kSteelPlate{0.003, 7850, 5900, 3230, 0, true};
const Wall kRubberPlate{0.010, 1100, 1600, 0, 0, true};

// A fluid layer by its transfer matrix, at the angle whose sine in the water is given: an
// independent route for plates without shear, and for all plates at normal incidence.
PlateResponse layer_response(const Wall& wall, double sine, double f_hz, bool air) {
  const double omega = 2 * kPi * f_hz;
  const Complex c = wall.speed_m_s * std::sqrt(Complex(1, wall.loss));
  const double xi = omega / kWater.sound_speed_m_s * sine;
  const Complex kz = std::sqrt(omega * omega / (c * c) - xi * xi);
  const Complex z1 = wall.density_kg_m3 * omega / kz, phase = kz * wall.thickness_m;
  const double z = kWater.density_kg_m3 * kWater.sound_speed_m_s / std::sqrt(1 - sine * sine);
  // (p, v) in front = M (p, v) behind.
  const Complex m11 = std::cos(phase), m12 = Complex(0, 1) * z1 * std::sin(phase);
  const Complex m21 = Complex(0, 1) / z1 * std::sin(phase), m22 = std::cos(phase);
  if (air) {
    const Complex in = m12 / m22;
    return {(in - z) / (in + z), 0};
  }
  const Complex p = m11 + m12 / z, v = m21 + m22 / z;
  return {(p - z * v) / (p + z * v), 2.0 / (p + z * v)};
}

Complex sum_of(std::span<const Tap> taps, double f_hz) {
  Complex sum = 0;
  for (const Tap& tap : taps) sum += tap.gain * std::polar(1.0, -2 * kPi * f_hz * tap.delay_s);
  return sum;
}

}  // namespace

TEST_CASE("a plate at normal incidence follows the transfer matrix", "[acoustics]") {
  for (Wall wall : {kSteelPlate, kRubberPlate, Wall{0.005, 1400, 2400, 1000, 0.05, true}}) {
    for (const double f : {2e5, 4.5e5, 7.5e5, 1.2e6}) {
      for (const bool air : {false, true}) {
        wall.water_inside = !air;
        const PlateResponse ours = plate_response(wall, kWater, 0, f);
        const PlateResponse matrix = layer_response(wall, 0, f, air);
        // 1e-5: the least loss that keeps the resonances finite.
        CHECK(std::abs(ours.reflected - matrix.reflected) < 1e-4);
        CHECK(std::abs(ours.transmitted - matrix.transmitted) < 1e-4);
      }
    }
  }
}

TEST_CASE("a plate without shear follows the transfer matrix at any angle", "[acoustics]") {
  for (const double sine : {0.1, 0.5, 0.8, 0.95}) {
    const PlateResponse ours = plate_response(kRubberPlate, kWater, sine, 7.5e5);
    const PlateResponse matrix = layer_response(kRubberPlate, sine, 7.5e5, false);
    CHECK(std::abs(ours.reflected - matrix.reflected) < 1e-4);
    CHECK(std::abs(ours.transmitted - matrix.transmitted) < 1e-4);
  }
}

TEST_CASE("a plate keeps the energy, and loses some if its loss factor is not 0", "[acoustics]") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 2000; ++i) {
    Wall wall{
        5e-4 + 0.02 * unit(random), 900 + 7000 * unit(random), 1500 + 4500 * unit(random), 0, 0,
        unit(random) < 0.7};
    if (unit(random) < 0.8) wall.shear_speed_m_s = wall.speed_m_s * (0.2 + 0.45 * unit(random));
    const double sine = unit(random), f = 1e5 + 1.5e6 * unit(random);
    const PlateResponse lossless = plate_response(wall, kWater, sine, f);
    // At a sharp resonance even the least loss absorbs a little.
    const double kept = std::norm(lossless.reflected) + std::norm(lossless.transmitted);
    CHECK(kept < 1 + 1e-9);
    CHECK(kept > 0.97);
    wall.loss = 0.05;
    const PlateResponse lossy = plate_response(wall, kWater, sine, f);
    CHECK(std::norm(lossy.reflected) + std::norm(lossy.transmitted) < 1 + 1e-9);
  }
}

TEST_CASE("a thin plate obeys the mass law", "[acoustics]") {
  const Wall thin{1e-5, 7850, 5900, 3230, 0, true};
  const double omega = 2 * kPi * 1e5, z = 1000 * 1480.0;
  const Complex expected = 1.0 / (1.0 + Complex(0, omega * 7850 * 1e-5 / (2 * z)));
  CHECK(std::abs(plate_response(thin, kWater, 0, 1e5).transmitted - expected) < 1e-3);
}

TEST_CASE("a solid plate is transparent where its bending wave fits the water", "[acoustics]") {
  // Above the coincidence frequency, T reaches 1 at the angle of each Lamb mode.
  double most = 0;
  for (int i = 1; i < 4000; ++i) {
    most = std::max(most,
                    std::abs(plate_response(kSteelPlate, kWater, i / 4000.0, 7.5e5).transmitted));
  }
  CHECK(most > 0.99);
}

TEST_CASE("the taps of a wall follow its response over the band", "[acoustics]") {
  const double carrier = 7.5e5, band = 1.5e5;
  for (const Wall& wall :
       {Wall{0.003, 7850, 5900, 3230, 0.01, true}, Wall{0.010, 1100, 1600, 0, 0.1, true},
        Wall{0.005, 1400, 2400, 1000, 0.05, false}}) {
    const WallResponse response = wall_response(wall, kWater, carrier, band);
    double error = 0, energy = 0, taps = 0;
    for (int k = 0; k < 256; k += 5) {
      const double sine = (k + 0.5) / 256;
      for (int i = 0; i < 50; ++i) {
        const double f = carrier + band * ((i + 0.5) / 50 - 0.5);
        const PlateResponse exact = plate_response(wall, kWater, sine, f);
        error += std::norm(exact.reflected - sum_of(response.at(sine).reflected, f));
        const double water_s =
            wall.thickness_m * std::sqrt(1 - sine * sine) / kWater.sound_speed_m_s;
        const Complex past_water = exact.transmitted * std::polar(1.0, 2 * kPi * f * water_s);
        error += std::norm(past_water - sum_of(response.at(sine).transmitted, f));
        energy += std::norm(exact.reflected) + std::norm(exact.transmitted);
      }
      taps += response.at(sine).reflected_energy + response.at(sine).transmitted_energy;
    }
    CHECK(error / energy < 0.01);
    CHECK(std::abs(50 * taps / energy - 1) < 0.05);
  }
}

TEST_CASE("a plate of water changes nothing", "[acoustics]") {
  const Wall water{0.02, kWater.density_kg_m3, kWater.sound_speed_m_s, 0, 0, true};
  const WallResponse response = wall_response(water, kWater, 7.5e5, 1.5e5);
  for (const double sine : {0.0, 0.3, 0.7, 0.95}) {
    const WallResponse::Angle& angle = response.at(sine);
    CHECK(angle.reflected_energy < 1e-6);
    REQUIRE(angle.transmitted.size() == 1);
    CHECK(std::abs(angle.transmitted[0].delay_s) < 1e-12);
    CHECK(std::abs(angle.transmitted[0].gain - 1.0) < 1e-3);
  }
}

TEST_CASE("the taps reach as late as sound takes through a wall", "[acoustics]") {
  const Wall thick{0.05, 1400, 2400, 1000, 0.02, true};
  const double carrier = 7.5e5, band = 2.6e5;
  const WallResponse response = wall_response(thick, kWater, carrier, band);
  for (const double sine : {0.1, 0.5, 0.9}) {
    const double middle = (std::floor(sine * 256) + 0.5) / 256;
    double energy = 0;
    constexpr int kSteps = 2000;
    for (int i = 0; i < kSteps; ++i) {
      const double f = carrier + band * ((i + 0.5) / kSteps - 0.5);
      energy += std::norm(plate_response(thick, kWater, middle, f).transmitted) / kSteps;
    }
    CHECK(response.at(sine).transmitted_energy == Approx(energy).epsilon(0.1));
  }
}

}  // namespace ensonify
