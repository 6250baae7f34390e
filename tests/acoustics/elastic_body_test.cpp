// Protects: the echo of elastic spheres and shells, against published target strengths, against
// the formulas of other authors, against limits, and against an integration of the equations of
// motion through the wall.
#include "acoustics/elastic_body.h"

#include <array>
#include <cmath>
#include <utility>

#include "catch.h"

#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr Water kSphereWater{1500, 0, {}, 1026};
constexpr double kWhole = 1;  // wall of a solid sphere of less than 1 m radius

double frequency_of(double ka, double radius_m) {
  return ka * kSphereWater.sound_speed_m_s / (2 * kPi * radius_m);
}

Complex echo_m(const ElasticBody& sphere, double ka) {
  return sphere_backscatter_m(sphere, kSphereWater, frequency_of(ka, sphere.radius_m));
}

double strength_db(const ElasticBody& sphere, const Water& water, double frequency_hz) {
  return 20 * std::log10(std::abs(sphere_backscatter_m(sphere, water, frequency_hz)));
}

double j(int n, double x) { return std::sph_bessel(static_cast<unsigned>(n), x); }
double y(int n, double x) { return std::sph_neumann(static_cast<unsigned>(n), x); }
double dj(int n, double x) { return n * j(n, x) / x - j(n + 1, x); }
double dy(int n, double x) { return n * y(n, x) / x - y(n + 1, x); }

// f of the series of any coefficients c_n.
template <class Coefficient>
Complex series_m(double ka, double radius_m, const Coefficient& c) {
  Complex sum = 0;
  for (int n = 0; n < ka + 4 * std::cbrt(ka) + 10; ++n) {
    sum += (n % 2 == 0 ? 1.0 : -1.0) * (2 * n + 1) * c(n);
  }
  return Complex(0, radius_m / ka) * sum;
}

// MacLennan 1981, equations 6 to 9: the phase eta of a solid sphere, c_n = i e^(i eta) sin(eta).
Complex maclennan(int n, double q, const SphereMaterial& m, const Water& water) {
  const double q1 = q * water.sound_speed_m_s / m.speed_m_s;
  const double q2 = q * water.sound_speed_m_s / m.shear_speed_m_s;
  const double density = m.density_kg_m3 / water.density_kg_m3;
  const double alpha = 2 * density * std::pow(m.shear_speed_m_s / water.sound_speed_m_s, 2);
  const double beta = density * std::pow(m.speed_m_s / water.sound_speed_m_s, 2) - alpha;
  const auto second = [n](double x) {
    return (n * (n + 1) / (x * x) - 1) * j(n, x) - 2 / x * dj(n, x);
  };
  const double a2 = (n * n + n - 2) * j(n, q2) + q2 * q2 * second(q2);
  const double a1 = 2.0 * n * (n + 1) * (q1 * dj(n, q1) - j(n, q1));
  const double b2 = a2 * q1 * q1 * (beta * j(n, q1) - alpha * second(q1)) -
                    a1 * alpha * (j(n, q2) - q2 * dj(n, q2));
  const double b1 = q * (a2 * q1 * dj(n, q1) - a1 * j(n, q2));
  const double eta = std::atan(-(b2 * dj(n, q) - b1 * j(n, q)) / (b2 * dy(n, q) - b1 * y(n, q)));
  return Complex(0, 1) * std::sin(eta) * std::polar(1.0, eta);
}

// Anderson, J. Acoust. Soc. Am. 22, 1950: a fluid sphere.
Complex anderson(int n, double ka, const SphereMaterial& m, const Water& water) {
  const double h = m.speed_m_s / water.sound_speed_m_s, inner = ka / h;
  const double gh = m.density_kg_m3 / water.density_kg_m3 * h;
  const double ratio = dj(n, inner) / j(n, inner);
  const double c = (ratio * y(n, ka) / dj(n, ka) - gh * dy(n, ka) / dj(n, ka)) /
                   (ratio * j(n, ka) / dj(n, ka) - gh);
  return -1.0 / Complex(1, -c);
}

// The order n of a shell by integrating the equations of motion through its wall: displacement u_r
// P_n, V dP_n, stresses s_rr P_n, s_rt dP_n.
struct IntegratedShell {
  const ElasticBody& sphere;
  double w;
  int n;

  using State = std::array<double, 4>;

  State slope(double r, const State& s) const {
    const SphereMaterial& m = sphere.material;
    const double mu = m.density_kg_m3 * m.shear_speed_m_s * m.shear_speed_m_s;
    const double lambda = m.density_kg_m3 * m.speed_m_s * m.speed_m_s - 2 * mu;
    const double nn = n * (n + 1.0), inertia = m.density_kg_m3 * w * w;
    const auto [u, v, rr, rt] = s;
    const double sides = (2 * u - nn * v) / r;
    const double du = (rr - lambda * sides) / (lambda + 2 * mu);
    const double pull = 2 * lambda * (du + sides) + 2 * mu * sides;
    return {du, rt / mu - (u - v) / r, -inertia * u - (2 * rr - pull - nn * rt) / r,
            -inertia * v - (lambda * (du + sides) + 2 * mu * (u + v * (1 - nn)) / r + 3 * rt) / r};
  }

  State outside(State s) const {
    constexpr int kSteps = 2000;
    const double b = sphere.radius_m - sphere.wall_m, h = sphere.wall_m / kSteps;
    const auto moved = [](const State& x, const State& k, double by) {
      State sum = x;
      for (int i = 0; i < 4; ++i) sum[i] += by * k[i];
      return sum;
    };
    for (int i = 0; i < kSteps; ++i) {
      const double r = b + i * h;
      const State k1 = slope(r, s), k2 = slope(r + h / 2, moved(s, k1, h / 2));
      const State k3 = slope(r + h / 2, moved(s, k2, h / 2)), k4 = slope(r + h, moved(s, k3, h));
      for (int c = 0; c < 4; ++c) s[c] += h / 6 * (k1[c] + 2 * k2[c] + 2 * k3[c] + k4[c]);
    }
    return s;
  }

  Complex coefficient() const {
    const double b = sphere.radius_m - sphere.wall_m, a = sphere.radius_m;
    const SphereFilling& filling = sphere.filling;
    State moved{1, 0, 0, 0};
    if (filling.density_kg_m3 > 0) {
      const double x = w / filling.speed_m_s * b;
      moved = {x / b * dj(n, x), 0, -filling.density_kg_m3 * w * w * j(n, x), 0};
    }
    const double stiffness = sphere.material.density_kg_m3 * sphere.material.speed_m_s * w;
    for (int i = 2; i < 4; ++i) moved[i] /= stiffness;
    State first = moved;
    first[2] *= stiffness;
    const State one = outside(first), other = outside({0, 1, 0, 0});
    const double share = n == 0 ? 0 : -one[3] / other[3];
    const double u = one[0] + share * other[0], p = -(one[2] + share * other[2]);
    const double ka = w / kSphereWater.sound_speed_m_s * a;
    const double motion = a * kSphereWater.density_kg_m3 * w * w * u;
    const Complex h(j(n, ka), -y(n, ka)), dh(dj(n, ka), -dy(n, ka));
    return -(ka * dj(n, ka) * p - motion * j(n, ka)) / (ka * dh * p - motion * h);
  }
};

}  // namespace

TEST_CASE("calibration spheres have their published target strengths", "[acoustics]") {
  const ElasticBody carbide{0.01905, kTungstenCarbide, kWhole}, copper{0.03, kCopper, kWhole};
  // The tests of acousticTS (Lucca), tungsten carbide of 38.1 mm, 1500 m/s, 1026 kg/m3.
  const std::pair<double, double> published[] = {
      {38e3, -42.4161095}, {70e3, -41.4364324}, {120e3, -39.5248183}, {200e3, -39.0544814}};
  for (const auto& [f, db] : published) {
    CAPTURE(f);
    CHECK(strength_db(carbide, kSphereWater, f) == Approx(db).margin(1e-4));
  }
  // The tests of echoSMs (ICES), 1477.3 m/s and 1026.8 kg/m3.
  const Water cold{1477.3, 0, {}, 1026.8};
  CHECK(strength_db(carbide, cold, 38e3) == Approx(-42.3297).margin(1e-4));
  CHECK(strength_db(copper, cold, 38e3) == Approx(-33.5507).margin(1e-4));
}

TEST_CASE("solid spheres follow MacLennan's formula", "[acoustics]") {
  for (const SphereMaterial& m : {kTungstenCarbide, kCopper, kAluminum, kSteel}) {
    for (const double ka : {0.3, 1.0, 4.0, 9.5, 23.0, 41.0}) {
      CAPTURE(m.density_kg_m3, ka);
      const Complex expected =
          series_m(ka, 0.02, [&](int n) { return maclennan(n, ka, m, kSphereWater); });
      CHECK(std::abs(echo_m({0.02, m, kWhole}, ka) - expected) < 1e-8 * 0.02);
    }
  }
}

TEST_CASE("a very stiff and heavy sphere is rigid", "[acoustics]") {
  const ElasticBody rigid{0.02, {1e12, 1e7, 6e6}, kWhole};
  for (const double ka : {0.05, 0.5, 3.0, 20.0, 60.0}) {
    CAPTURE(ka);
    const Complex expected =
        series_m(ka, 0.02, [&](int n) { return -dj(n, ka) / Complex(dj(n, ka), -dy(n, ka)); });
    CHECK(std::abs(echo_m(rigid, ka) - expected) < 1e-6 * std::abs(expected));
  }
  // Geometrical optics: a/2 from the nearest point, 2a/c before the center.
  for (const double ka : {300.0, 600.0}) {
    CHECK(std::abs(echo_m(rigid, ka) / (0.01 * std::polar(1.0, 2 * ka)) - 1.0) < 2 / ka);
  }
}

TEST_CASE("a sphere without shear follows Anderson's formula", "[acoustics]") {
  for (const SphereMaterial& m : {SphereMaterial{1028.9, 1480.3, 0}, SphereMaterial{1.24, 345, 0},
                                  SphereMaterial{800, 1300, 0}, SphereMaterial{2000, 2500, 0}}) {
    for (const double ka : {0.11, 0.7, 2.0, 9.0, 25.0}) {
      CAPTURE(m.density_kg_m3, ka);
      const Complex expected =
          series_m(ka, 0.02, [&](int n) { return anderson(n, ka, m, kSphereWater); });
      CHECK(std::abs(echo_m({0.02, m, kWhole}, ka) - expected) < 1e-8 * 0.02);
      // A slight shear stiffness changes little.
      if (m.density_kg_m3 < 1000 || ka > 3) continue;
      const SphereMaterial jelly{m.density_kg_m3, m.speed_m_s, 1};
      CHECK(std::abs(echo_m({0.02, jelly, kWhole}, ka) - expected) < 0.02 * std::abs(expected));
    }
  }
}

TEST_CASE("a small sphere echoes after Rayleigh", "[acoustics]") {
  const double ka = 0.05, a = 0.02, k = ka / a;
  for (const SphereMaterial& m : {kTungstenCarbide, kCopper, kAluminum, kSteel}) {
    const double bulk = m.density_kg_m3 * (m.speed_m_s * m.speed_m_s -
                                           4.0 / 3 * m.shear_speed_m_s * m.shear_speed_m_s);
    const double water = kSphereWater.density_kg_m3 * 1500 * 1500.0;
    const double g = m.density_kg_m3 / kSphereWater.density_kg_m3;
    const double expected = k * k * a * a * a / 3 * (water / bulk - 1 - 3 * (g - 1) / (2 * g + 1));
    CHECK(std::abs(echo_m({a, m, kWhole}, ka) / expected - 1.0) < 0.003);
  }
}

TEST_CASE("a shell follows the equations of motion through its wall", "[figure]") {
  const SphereFilling water{1000, 1480};
  for (const auto& [material, filling] : {std::pair{kSteel, water},
                                          {kAluminum, kAir},
                                          {kAluminum, SphereFilling{}},
                                          {kCopper, water}}) {
    for (const double wall : {0.0005, 0.004, 0.015}) {
      const ElasticBody sphere{0.02, material, wall, filling};
      for (const double ka : {0.2, 2.0, 7.7}) {
        const double f = frequency_of(ka, 0.02);
        const auto modes = sphere_modes(sphere, kSphereWater, f);
        for (int n = 0; n < 9; ++n) {
          CAPTURE(wall, ka, n);
          const Complex expected = IntegratedShell{sphere, 2 * kPi * f, n}.coefficient();
          CHECK(std::abs(modes[static_cast<std::size_t>(n)] - expected) <
                1e-9 + 1e-4 * std::abs(expected));
        }
      }
    }
  }
}

TEST_CASE("shells tend to what they must", "[acoustics]") {
  const SphereFilling water{kSphereWater.density_kg_m3, kSphereWater.sound_speed_m_s};
  for (const double ka : {0.5, 5.0, 31.0, 120.0}) {
    CAPTURE(ka);
    const Complex solid = echo_m({0.02, kSteel, kWhole}, ka);
    CHECK(echo_m({0.02, kSteel, 0.02}, ka) == solid);
    CHECK(std::abs(echo_m({0.02, kSteel, 0.02 * (1 - 1e-5), kAir}, ka) - solid) < 1e-6 * 0.02);
    // A thin wall around water is not heard; one without shear or contrast neither.
    CHECK(std::abs(echo_m({0.02, kAluminum, 1e-8, water}, ka)) < 1e-3 * 0.02);
    const SphereMaterial same{1026, 1500, 0};
    CHECK(std::abs(echo_m({0.02, same, 0.003, water}, ka)) < 1e-10);
    // A bubble in a shell of water is the bubble.
    const SphereMaterial air{kAir.density_kg_m3, kAir.speed_m_s, 0};
    CHECK(std::abs(echo_m({0.02, same, 0.005, kAir}, ka) -
                   echo_m({0.015, air, kWhole}, 0.75 * ka)) < 1e-8 * 0.02);
  }
}

TEST_CASE("spheres return the energy that they take", "[acoustics]") {
  const SphereFilling water{1025, 1500};
  for (const ElasticBody& sphere :
       {ElasticBody{0.02, kTungstenCarbide, kWhole}, ElasticBody{0.02, kAluminum, 2e-5, kAir},
        ElasticBody{0.02, kSteel, 0.001, water}, ElasticBody{0.02, {900, 2000, 0}, kWhole}}) {
    for (const double ka : {0.05, 1.0, 12.3, 77.0, 600.0}) {
      const auto modes = sphere_modes(sphere, kSphereWater, frequency_of(ka, 0.02));
      for (const Complex& c : modes) {
        CAPTURE(ka, c);
        CHECK(std::abs(std::abs(1.0 + 2.0 * c) - 1) < 1e-12);
      }
      CHECK(std::abs(modes.back()) < 1e-6);
    }
  }
}

TEST_CASE("taps ring as the sphere does", "[acoustics]") {
  const ElasticBody sphere{0.01905, kTungstenCarbide, kWhole};
  for (const auto& [carrier, band] : {std::pair{38e3, 4e3}, {120e3, 20e3}, {400e3, 60e3}}) {
    const ElasticTaps found = sphere_taps(sphere, kSphereWater, carrier, band);
    CHECK(found.error < 1e-3);
    double missing = 0, all = 0;
    for (int i = 0; i < 1000; ++i) {
      const double f = carrier + band * ((i + 0.5) / 1000 - 0.5);
      Complex sum = 0;
      for (const Tap& tap : found.taps)
        sum += tap.gain * std::polar(1.0, -2 * kPi * f * tap.delay_s);
      const Complex wanted = sphere_backscatter_m(sphere, kSphereWater, f);
      missing += std::norm(sum - wanted);
      all += std::norm(wanted);
    }
    CHECK(missing / all < 1.5e-3);
  }
  // The first echo is that of the nearest point, a/2 times the reflection coefficient.
  const ElasticTaps wide = sphere_taps({0.05, kSteel, kWhole}, kSphereWater, 750e3, 400e3);
  const double a_c = 0.05 / 1500, impedance = 7850.0 * 5960 / (1026.0 * 1500);
  std::size_t first = 0;
  while (std::abs(wide.taps[first].gain) < 0.01) ++first;
  CHECK(wide.taps[first].delay_s == Approx(-2 * a_c).margin(0.3 / 400e3));
  CHECK(std::abs(wide.taps[first].gain) ==
        Approx(0.025 * (impedance - 1) / (impedance + 1)).epsilon(0.1));
}

}  // namespace ensonify
