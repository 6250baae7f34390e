// Protects: the echo of elastic cylinders, against the formulas of other authors, an integration of
// the equations of motion through the wall, limits, and their taps.
#include "acoustics/elastic_body.h"

#include <array>
#include <cmath>

#include "acoustics/bessel.h"
#include "catch.h"
#include "core/units.h"

namespace ensonify {
namespace {

using Amplitude = std::complex<double>;

constexpr Water kCylinderWater{1500, 0, {}, 1026};
constexpr double kRod_m = 0.02;

double cylinder_hz(double ka) { return ka * kCylinderWater.sound_speed_m_s / (2 * kPi * kRod_m); }

double cj(int n, double x) { return std::cyl_bessel_j(n, x); }
double cy(int n, double x) { return std::cyl_neumann(n, x); }
double dcj(int n, double x) { return n * cj(n, x) / x - cj(n + 1, x); }
double dcy(int n, double x) { return n * cy(n, x) / x - cy(n + 1, x); }

// -(x j' p - u j)/(x h' p - u h) with the surface's motion u and pressure p.
Amplitude scattered(int n, double x, double u, double p) {
  const double of_j = x * dcj(n, x) * p - u * cj(n, x), of_y = x * dcy(n, x) * p - u * cy(n, x);
  return -of_j / Amplitude(of_j, -of_y);
}

TEST_CASE("cylindrical Bessel functions keep their digits over all orders") {
  for (const double x : {0.3, 2.0, 17.0, 240.0}) {
    const auto j = cylindrical_j(300, x), y = cylindrical_y(300, x);
    for (int n = 0; n < 300; n += 7) {
      CAPTURE(x, n);
      const auto at = static_cast<std::size_t>(n);
      if (n < x + 60) {
        CHECK(std::ldexp(j[at].value, j[at].exponent) == Approx(cj(n, x)).epsilon(1e-9).margin(1e-300));
        CHECK(std::ldexp(y[at].value, y[at].exponent) == Approx(cy(n, x)).epsilon(1e-9));
      }
      // The Wronskian x (J Y' - J' Y) = 2/pi, at any order.
      const double product = std::ldexp(j[at].value * y[at].slope - j[at].slope * y[at].value,
                                        j[at].exponent + y[at].exponent);
      CHECK(product == Approx(2 / kPi).epsilon(1e-9));
    }
  }
}

TEST_CASE("a very stiff and heavy cylinder is rigid") {
  const ElasticBody rigid{kRod_m, {1e12, 1e7, 6e6}, 1};
  for (const double ka : {0.1, 1.0, 8.0, 40.0}) {
    const auto modes = cylinder_modes(rigid, kCylinderWater, cylinder_hz(ka));
    for (int n = 0; n < 10; ++n) {
      CAPTURE(ka, n);
      const Amplitude expected = -dcj(n, ka) / Amplitude(dcj(n, ka), -dcy(n, ka));
      CHECK(std::abs(modes[static_cast<std::size_t>(n)] - expected) <
            1e-6 * std::abs(expected) + 1e-15);
    }
  }
  // Geometrical optics: sqrt(a/(2 lambda)) per length, from 2a/c before the axis.
  const double ka = 500, wavelength = 2 * kPi * kRod_m / ka;
  const Amplitude echo = cylinder_backscatter(rigid, kCylinderWater, cylinder_hz(ka));
  const Amplitude expected = std::polar(std::sqrt(kRod_m / (2 * wavelength)), 2 * ka + kPi / 4);
  CHECK(std::abs(echo / expected - 1.0) < 3 / ka);
}

// Faran 1951: the phase eta of a solid cylinder.
TEST_CASE("solid cylinders follow Faran's formula") {
  for (const SphereMaterial& m : {kTungstenCarbide, kAluminum, kSteel}) {
    for (const double ka : {0.4, 2.0, 7.3, 21.0}) {
      const double x1 = ka * 1500 / m.speed_m_s, x2 = ka * 1500 / m.shear_speed_m_s;
      const auto modes = cylinder_modes({kRod_m, m, 1}, kCylinderWater, cylinder_hz(ka));
      // The formula cancels at orders far above ka.
      for (int n = 0; n < ka + 6; ++n) {
        CAPTURE(m.density_kg_m3, ka, n);
        const auto alpha = [n](double x) { return -x * dcj(n, x) / cj(n, x); };
        const double a1 = alpha(x1), a2 = alpha(x2), nn = n * n, half = x2 * x2 / 2;
        const double above = a1 / (a1 + 1) - (n == 0 ? 0 : nn / (a2 + nn - half));
        const double below = (a1 + nn - half) / (a1 + 1) -
                             (n == 0 ? 0 : nn * (a2 + 1) / (a2 + nn - half));
        const double tan_phi = kCylinderWater.density_kg_m3 / m.density_kg_m3 * half * above / below;
        // tan(Phi) = u/p of the surface.
        const Amplitude expected = scattered(n, ka, tan_phi, 1);
        CHECK(std::abs(modes[static_cast<std::size_t>(n)] - expected) < 1e-8);
      }
    }
  }
}

// Plane strain in order n, (u_r, u_t, s_rr, s_rt) from the inner side outward by Runge and Kutta.
struct CylinderWall {
  const ElasticBody& body;
  double w;
  int n;
  using State = std::array<double, 4>;

  State slope(double r, const State& s) const {
    const double rho = body.material.density_kg_m3;
    const double mu = rho * std::pow(body.material.shear_speed_m_s, 2);
    const double stiff = rho * std::pow(body.material.speed_m_s, 2), lambda = stiff - 2 * mu;
    const double hoop = (s[0] + n * s[1]) / r;
    const double du = (s[2] - lambda * hoop) / stiff;
    const double tt = lambda * du + stiff * hoop;
    return {du, s[3] / mu + (n * s[0] + s[1]) / r,
            -rho * w * w * s[0] - (s[2] - tt) / r - n * s[3] / r,
            -rho * w * w * s[1] - 2 * s[3] / r + n * tt / r};
  }
  State outward(State s) const {
    constexpr int kSteps = 4000;
    const double b = body.radius_m - body.wall_m, h = body.wall_m / kSteps;
    const auto plus = [](State x, double f, const State& y) {
      for (int i = 0; i < 4; ++i) x[i] += f * y[i];
      return x;
    };
    for (int i = 0; i < kSteps; ++i) {
      const double r = b + i * h;
      const State k1 = slope(r, s), k2 = slope(r + h / 2, plus(s, h / 2, k1));
      const State k3 = slope(r + h / 2, plus(s, h / 2, k2)), k4 = slope(r + h, plus(s, h, k3));
      s = plus(plus(plus(plus(s, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
    }
    return s;
  }
  Amplitude coefficient() const {
    // Stresses in units of rho c^2 of the wall keep the numbers alike.
    const double b = body.radius_m - body.wall_m;
    State filled{1, 0, 0, 0};
    if (body.filling.density_kg_m3 > 0) {
      const double x = w / body.filling.speed_m_s * b;
      const double u = x * dcj(n, x) / (body.filling.density_kg_m3 * w * w * b);
      filled = {u, 0, -cj(n, x), 0};
    }
    const State a = outward(filled);
    State s = a;
    if (n > 0) {
      const double scale = std::abs(filled[0]) + 1e-30;
      const State c = outward({0, scale, 0, 0});
      for (int i = 0; i < 4; ++i) s[i] = a[i] * c[3] - c[i] * a[3];
    }
    const double x = w / kCylinderWater.sound_speed_m_s * body.radius_m;
    return scattered(n, x, kCylinderWater.density_kg_m3 * w * w * body.radius_m * s[0], -s[2]);
  }
};

TEST_CASE("a cylindrical shell follows the equations of motion through its wall", "[figure]") {
  for (const auto& [material, filling] : {std::pair{kSteel, SphereFilling{1000, 1480}},
                                          {kAluminum, kAir}, {kAluminum, SphereFilling{}}}) {
    for (const double wall : {0.0005, 0.004, 0.015}) {
      const ElasticBody shell{kRod_m, material, wall, filling};
      for (const double ka : {0.3, 2.0, 7.7}) {
        const auto modes = cylinder_modes(shell, kCylinderWater, cylinder_hz(ka));
        for (int n = 0; n < 8; ++n) {
          CAPTURE(wall, ka, n);
          const Amplitude expected = CylinderWall{shell, 2 * kPi * cylinder_hz(ka), n}.coefficient();
          CHECK(std::abs(modes[static_cast<std::size_t>(n)] - expected) <
                1e-9 + 1e-4 * std::abs(expected));
        }
      }
    }
  }
}

TEST_CASE("cylinders return the energy that they take, and water in water is silent") {
  for (const double wall : {0.002, 1.0}) {
    for (const double ka : {0.2, 5.0, 90.0, 400.0}) {
      const auto modes =
          cylinder_modes({kRod_m, kSteel, wall, kAir}, kCylinderWater, cylinder_hz(ka));
      for (const Amplitude& c : modes) CHECK(std::abs(1.0 + 2.0 * c) == Approx(1).epsilon(1e-12));
    }
  }
  const SphereFilling water{1026, 1500};
  for (const double wall : {0.003, 1.0}) {
    const ElasticBody same{kRod_m, {1026, 1500, 0}, wall, water};
    CHECK(std::abs(cylinder_backscatter(same, kCylinderWater, cylinder_hz(9))) < 1e-12);
  }
}

TEST_CASE("taps ring as the cylinder does") {
  const ElasticBody shell{0.05, kSteel, 0.003, kAir};
  const ElasticTaps taps = cylinder_taps(shell, kCylinderWater, 120e3, 30e3);
  CHECK(taps.error < 0.02);
  double missing = 0, all = 0;
  for (double f = 105.3e3; f < 135e3; f += 370) {
    Amplitude sum = 0;
    for (const Tap& tap : taps.taps) sum += tap.gain * std::polar(1.0, -2 * kPi * f * tap.delay_s);
    const Amplitude exact = cylinder_backscatter(shell, kCylinderWater, f);
    missing += std::norm(sum - exact);
    all += std::norm(exact);
  }
  CHECK(missing < 2 * taps.error * all + 1e-3 * all);
}

}  // namespace
}  // namespace ensonify
