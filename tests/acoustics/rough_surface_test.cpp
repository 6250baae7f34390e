// Protects: the energy that roughness takes from a specular echo. The integral over the surface's
// correlation by quadrature, both limits, conservation of energy, and the table.
#include "acoustics/scattering.h"

#include <cmath>

#include "catch.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr double kRoughWavelength_m = 1.6e-3;
constexpr double kRoughWavenumber = 2 * kPi / kRoughWavelength_m;

// (R k / (2 pi cos alpha))^2 int [e^(-g (1 - rho)) - e^(-g)] J_0(2k d sin alpha) 2 pi d dd,
// rho = e^(-(d/L)^2): what the sum over n integrates term by term.
double by_quadrature(const RoughSurface& surface, double alpha) {
  const double cosine = std::cos(alpha), turn = 2 * kRoughWavenumber * std::sin(alpha);
  const double kh = kRoughWavenumber * surface.height_rms_m * cosine, g = 4 * kh * kh;
  const double longest = surface.correlation_m * std::sqrt(std::log(std::max(g, 1.0)) + 40);
  constexpr int kSteps = 40000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double d = longest * (i + 0.5) / kSteps, x = d / surface.correlation_m;
    const double rho = std::exp(-x * x);
    sum += std::exp(-g) * std::expm1(g * rho) * std::cyl_bessel_j(0, turn * d) * 2 * kPi * d;
  }
  const double front = surface.reflection * kRoughWavenumber / (2 * kPi * cosine);
  return front * front * sum * longest / kSteps;
}

double rough_strength(const RoughSurface& surface, double alpha) {
  return rough_backscatter_strength(surface, kRoughWavelength_m, std::cos(alpha));
}

TEST_CASE("backscatter of a rough surface is the integral over its correlation") {
  for (const double kh : {0.05, 0.5, 2.0, 5.0}) {
    const RoughSurface surface{0.8, kh / kRoughWavenumber, 12 / kRoughWavenumber};
    for (const double deg : {0.0, 3.0, 10.0, 20.0}) {
      const double expected = by_quadrature(surface, radians(deg));
      // The quadrature loses digits where the integrand cancels.
      if (expected < 1e-6) continue;
      CHECK(rough_strength(surface, radians(deg)) == Approx(expected).epsilon(1e-5));
    }
  }
}

TEST_CASE("slight roughness scatters by its spectrum, and strong roughness by its slopes") {
  const RoughSurface slight{1, 1e-3 / kRoughWavenumber, 8 / kRoughWavenumber};
  for (const double deg : {0.0, 5.0, 15.0}) {
    const double k = kRoughWavenumber, kl = 8 * std::sin(radians(deg));
    const double first_order = std::pow(k, 4) * std::pow(slight.height_rms_m, 2) *
                               std::pow(slight.correlation_m * std::cos(radians(deg)), 2) / kPi *
                               std::exp(-kl * kl) / std::pow(std::cos(radians(deg)), 2);
    CHECK(rough_strength(slight, radians(deg)) == Approx(first_order).epsilon(1e-4));
  }
  // Below and above the limit where the slopes take over.
  const double height = std::sqrt(1000.0 / 4) / kRoughWavenumber;
  for (const double deg : {0.0, 5.0, 10.0}) {
    const double c = std::cos(radians(deg));
    const double below = rough_strength({1, height * 0.9999 / c, 20 * height}, radians(deg));
    const double above = rough_strength({1, height * 1.0001 / c, 20 * height}, radians(deg));
    CHECK(below == Approx(above).epsilon(0.02));
  }
}

// At normal incidence, the energy in all directions is what the specular reflection has lost:
// int s(K) d^2K/k^2 = R^2 (1 - e^(-g)), with s at the transverse wavenumber K = 2k sin(alpha).
TEST_CASE("a rough surface scatters the energy that the specular reflection loses") {
  for (const double kh : {0.1, 0.4, 1.0}) {
    const RoughSurface surface{0.9, kh / kRoughWavenumber, 60 / kRoughWavenumber};
    double sum = 0;
    constexpr int kSteps = 4000;
    constexpr double kWidest_rad = 0.3;
    for (int i = 0; i < kSteps; ++i) {
      const double a = kWidest_rad * (i + 0.5) / kSteps;
      sum += rough_strength(surface, a) * 8 * kPi * std::sin(a) * std::cos(a) * kWidest_rad / kSteps;
    }
    const double kept =
        coherent_reflection(surface.reflection, surface.height_rms_m, kRoughWavelength_m, 1);
    CHECK(sum == Approx(0.81 - kept * kept).epsilon(0.01));
  }
}

// A narrow lobe needs finer steps.
TEST_CASE("the table of a rough surface is right between its rows") {
  for (const double kl : {20.0, 400.0, 4000.0}) {
    const RoughSurface surface{1, 0.2 / kRoughWavenumber, kl / kRoughWavenumber};
    const BackscatterTable table = rough_backscatter_table(surface, kRoughWavelength_m);
    const std::size_t rows = table.grazing_rad.size();
    for (std::size_t i = rows - 2; i > rows - 2 - rows / 20; i -= 7) {
      const double between = (table.grazing_rad[i] + table.grazing_rad[i + 1]) / 2;
      const double exact_db = 10 * std::log10(rough_strength(surface, kPi / 2 - between));
      if (exact_db < -200) break;
      CHECK((table.strength_db[i] + table.strength_db[i + 1]) / 2 == Approx(exact_db).margin(0.05));
    }
  }
}

TEST_CASE("the table of a rough surface, and its part of the moments") {
  const RoughSurface surface{1, 0.3e-3, 3e-3};
  Material material;
  material.reflectivity = 1e-3;
  const double plain = scatterer_moments(material, 0.5, std::cos(0.2), 3, 1e-4).variance_m2;
  material.rough =
      std::make_shared<const BackscatterTable>(rough_backscatter_table(surface, kRoughWavelength_m));
  for (const double a : {0.0, 0.1, 0.2, 0.4}) {
    const double law = 0.5 * 1e-3 * std::cos(a) * std::cos(a);
    const double expected = (law + rough_strength(surface, a)) / std::cos(a) * 9 * 1e-4;
    CHECK(scatterer_moments(material, 0.5, std::cos(a), 3, 1e-4).variance_m2 ==
          Approx(expected).epsilon(1e-3));
  }
  CHECK(scatterer_moments(material, 0.5, std::cos(0.2), 3, 1e-4).variance_m2 > 2 * plain);
  CHECK(rough_backscatter_strength({1, 0, 3e-3}, kRoughWavelength_m, 1) == 0);
  CHECK(rough_backscatter_strength(surface, kRoughWavelength_m, 0) == 0);
  CHECK(material.rough->strength_db.front() == -300);
}

}  // namespace
}  // namespace ensonify
