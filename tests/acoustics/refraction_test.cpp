#include "acoustics/refraction.h"

#include <cmath>
#include <random>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

constexpr double kGradient = 0.5;  // 1/s

// c = 1500 + g z between -1000 m and 1000 m.
SoundLayers one_gradient(double gradient_s) {
  return make_layers({0, {-1000, 1000}, {1500 + 1000 * gradient_s, 1500 - 1000 * gradient_s}});
}

// A thermocline over a slow mixed layer and a rising deep end, as a summer's sea has it.
SoundLayers summer_sea() {
  return make_layers({0, {0, 8, 12, 20, 60, 200}, {1521, 1520.5, 1502, 1495, 1492, 1494}});
}

RayPoint follow(const SoundLayers& layers, double z_m, double phi_rad, double path_m) {
  RayArc arc = start_ray(layers, z_m, std::cos(phi_rad), std::sin(phi_rad));
  while (arc.start.path_m + arc.length_m < path_m) arc = next_arc(layers, arc);
  return point_on(arc, path_m - arc.start.path_m);
}

struct Stepped {
  double x = 0, z = 0, phi = 0, time = 0;
};

// The ray equations dphi/ds = -c'(z) cos(phi)/c by Runge and Kutta's fourth-order rule.
Stepped stepped(const SoundLayers& layers, double z_m, double phi_rad, double path_m, int steps) {
  const auto slope = [&](const Stepped& at) {
    const double c = sound_speed_at(layers, at.z), h = 1e-4;
    const double gradient =
        (sound_speed_at(layers, at.z + h) - sound_speed_at(layers, at.z - h)) / (2 * h);
    return Stepped{std::cos(at.phi), std::sin(at.phi), -gradient * std::cos(at.phi) / c, 1 / c};
  };
  const auto moved = [](const Stepped& a, double h, const Stepped& d) {
    return Stepped{a.x + h * d.x, a.z + h * d.z, a.phi + h * d.phi, a.time + h * d.time};
  };
  Stepped at{0, z_m, phi_rad, 0};
  const double h = path_m / steps;
  for (int i = 0; i < steps; ++i) {
    const Stepped a = slope(at), b = slope(moved(at, h / 2, a)), c = slope(moved(at, h / 2, b)),
                  d = slope(moved(at, h, c));
    at = moved(moved(moved(moved(at, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
  }
  return at;
}

}  // namespace

// Protects the shape of rays: in a constant gradient they are circles about c = 0.
TEST_CASE("points of a ray lie on the circle of radius c/(g cos phi)") {
  const SoundLayers layers = one_gradient(kGradient);
  for (const double phi : {-1.2, -0.3, 0.0, 0.4, 1.5}) {
    const double radius = 1500 / (kGradient * std::cos(phi));
    const double centre_x = radius * std::sin(phi), centre_z = -1500 / kGradient;
    for (const double s : {0.1, 3.0, 60.0, 700.0}) {
      const RayPoint at = follow(layers, 0, phi, s);
      INFO(phi << " " << s);
      const double found = std::hypot(at.x_m - centre_x, at.z_m - centre_z);
      CHECK(found == Approx(radius).epsilon(1e-12));
      CHECK(at.cos_phi / at.speed_m_s == Approx(std::cos(phi) / 1500).epsilon(1e-12));
      CHECK(at.path_m == Approx(s).epsilon(1e-14));
      CHECK(at.x_m / std::cos(phi) == Approx(at.lateral_m).epsilon(1e-12));
    }
  }
}

// Protects the delay: two closed forms of it that share nothing, and the integral of ds/c.
TEST_CASE("travel time is the integral of ds/c and the textbook's acosh") {
  for (const double gradient : {0.5, -0.5, 1e-2, 30.0}) {
    const SoundLayers layers =
        make_layers({0, {-40, 49}, {1500 + 40 * gradient, 1500 - 49 * gradient}});
    for (const double phi : {-0.6, 0.02, 0.5}) {
      const double s = 50;
      const RayPoint at = follow(layers, 0, phi, s);
      INFO(gradient << " " << phi);
      const int n = 2000;  // Simpson
      double sum = 0;
      for (int i = 0; i <= n; ++i) {
        const int weight = i == 0 || i == n ? 1 : i % 2 == 1 ? 4 : 2;
        const RayPoint middle = follow(layers, 0, phi, s * i / n);
        sum += weight / (1500 + gradient * middle.z_m);
      }
      CHECK(at.time_s == Approx(sum * s / (3 * n)).epsilon(1e-11));
      const double d2 = at.x_m * at.x_m + at.z_m * at.z_m;
      const double cosh = 1 + gradient * gradient * d2 / (2 * 1500 * at.speed_m_s);
      // Near 1 the arcosh keeps half the digits.
      CHECK(at.time_s == Approx(std::acosh(cosh) / std::abs(gradient)).epsilon(1e-6));
      if (std::abs(gradient) > 1) {
        CHECK(at.time_s == Approx(std::acosh(cosh) / std::abs(gradient)).epsilon(1e-13));
      }
    }
  }
}

// Protects the way through layers, against an integrator that knows none.
TEST_CASE("a ray through the layers of a sea is that of the ray equations") {
  const SoundLayers layers = summer_sea();
  for (const double phi : {-0.9, -0.35, -0.2, 0.3}) {
    const RayPoint at = follow(layers, -5, phi, 70);
    const Stepped other = stepped(layers, -5, phi, 70, 70000);
    INFO(phi);
    // A step of 1 mm over a kink of c turns the ray by up to 2.3/1500 x 1 mm / 2.
    CHECK(at.x_m == Approx(other.x).margin(5e-5));
    CHECK(at.z_m == Approx(other.z).margin(5e-5));
    CHECK(at.time_s == Approx(other.time).epsilon(1e-8));
    CHECK(at.cos_phi / at.speed_m_s ==
          Approx(std::cos(phi) / sound_speed_at(layers, -5)).epsilon(1e-13));
  }
}

// Protects against rays that pass where they must turn.
TEST_CASE("a ray turns where c reaches c_0/cos(phi)") {
  // Slower upwards: bent up. From 0 at -0.1 it turns where c = 1500/cos(0.1).
  const SoundLayers layers = one_gradient(-kGradient);
  const double radius = 1500 / (kGradient * std::cos(0.1));
  const RayPoint lowest = follow(layers, 0, -0.1, radius * 0.1);
  CHECK(lowest.sin_phi == Approx(0).margin(1e-13));
  CHECK(lowest.z_m == Approx(-radius * (1 - std::cos(0.1))).epsilon(1e-11));
  CHECK(lowest.speed_m_s == Approx(1500 / std::cos(0.1)).epsilon(1e-13));
  // Layers cut the arc into pieces and change nothing.
  SoundProfile cut{0, {}, {}};
  for (int i = -1000; i <= 1000; ++i) {
    cut.depth_m.push_back(i);
    cut.speed_m_s.push_back(1500 + kGradient * i);
  }
  const RayPoint whole = follow(layers, 0.25, -0.1, 700);
  const RayPoint pieces = follow(make_layers(cut), 0.25, -0.1, 700);
  CHECK(pieces.x_m == Approx(whole.x_m).epsilon(1e-10));
  CHECK(pieces.z_m == Approx(whole.z_m).epsilon(1e-9));
  CHECK(pieces.time_s == Approx(whole.time_s).epsilon(1e-11));
  CHECK(pieces.spread_m == Approx(whole.spread_m).epsilon(1e-10));
  CHECK(pieces.lateral_m == Approx(whole.lateral_m).epsilon(1e-10));
}

// Protects the spreading, also past kinks, turning points and caustics.
TEST_CASE("the tube is what neighbouring rays enclose") {
  const SoundLayers layers = summer_sea();
  for (const double phi : {-1.2, -0.5, -0.2, -0.12, 0.05, 0.3}) {
    for (const double s : {4.0, 30.0, 90.0}) {
      const double step = 1e-6;
      const RayPoint at = follow(layers, -9, phi, s), high = follow(layers, -9, phi + step, s),
                     low = follow(layers, -9, phi - step, s);
      const double apart = (high.z_m - low.z_m) * at.cos_phi - (high.x_m - low.x_m) * at.sin_phi;
      INFO(phi << " " << s);
      CHECK(at.spread_m == Approx(apart / (2 * step)).epsilon(1e-5).margin(1e-6));
      CHECK(at.lateral_m == Approx(at.x_m / std::cos(phi)).epsilon(1e-12));
    }
  }
  const RayPoint up = follow(layers, -9, kPi / 2, 5);
  CHECK(up.lateral_m == Approx(up.spread_m).epsilon(0.1));
  CHECK(std::isfinite(tube_area_m2(up)));
}

// Protects energy: the tubes of all rays, laid on a plane, are the plane.
TEST_CASE("tubes cover a plane once") {
  const SoundLayers layers = make_layers({0, {0, 10, 30, 60}, {1520, 1515, 1496, 1494}});
  const double floor_z = -45, steep = -1.5, flat = -0.6;
  const int n = 4000;
  double area = 0;
  const auto on_floor = [&](double phi) {
    RayArc arc = start_ray(layers, -2, std::cos(phi), std::sin(phi));
    while (arc.layer != 1) arc = next_arc(layers, arc);
    // Newton on the last arc: a route to the floor of its own.
    double s = 0;
    for (int i = 0; i < 60; ++i) {
      const RayPoint at = point_on(arc, s);
      s += (floor_z - at.z_m) / at.sin_phi;
    }
    return point_on(arc, s);
  };
  for (int i = 0; i < n; ++i) {
    const double low = steep + (flat - steep) * i / n, high = steep + (flat - steep) * (i + 1) / n;
    const RayPoint at = on_floor((low + high) / 2);
    CHECK(at.z_m == Approx(floor_z).epsilon(1e-12));
    const double solid_angle = 2 * kPi * (std::sin(high) - std::sin(low));
    area += tube_area_m2(at) * solid_angle / std::abs(at.sin_phi);
  }
  const double outer = on_floor(flat).x_m, inner = on_floor(steep).x_m;
  CHECK(area == Approx(kPi * (outer * outer - inner * inner)).epsilon(1e-6));
}

// Protects scenarios whose profile hardly changes: no cliff between bent and straight.
TEST_CASE("as the gradient goes to nothing rays become straight") {
  for (const double gradient : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0, -1e-9}) {
    const SoundLayers layers = one_gradient(gradient);
    for (const double phi : {-1.0, -1e-9, 0.0, 0.3}) {
      const RayPoint at = follow(layers, 1, phi, 60);
      INFO(gradient << " " << phi);
      const double off = 60 * 60 * std::abs(gradient) / 1500 + 1e-12;
      CHECK(std::abs(at.x_m - 60 * std::cos(phi)) <= off);
      CHECK(std::abs(at.z_m - 1 - 60 * std::sin(phi)) <= off);
      CHECK(std::abs(at.time_s * at.speed_m_s - 60) <= off);
      CHECK(std::abs(tube_area_m2(at) - 3600) <= 60 * off + 1e-9);
    }
  }
}

// Protects point targets and fish: there and back again, and the shortest of the ways.
TEST_CASE("the ray from a to b is the ray from b to a") {
  const SoundLayers layers = summer_sea();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> depth(-40, -1), aside(0.01, 60);
  int found = 0;
  for (int i = 0; i < 300; ++i) {
    const double a = depth(random), b = depth(random), x = aside(random);
    const auto there = find_eigenray(layers, a, x, b), back = find_eigenray(layers, b, x, a);
    INFO(a << " " << b << " " << x);
    REQUIRE(there.has_value() == back.has_value());
    if (!there) continue;
    ++found;
    CHECK(there->end.x_m == Approx(x).epsilon(1e-10));
    CHECK(there->end.z_m == Approx(b).margin(1e-8));
    CHECK(there->end.time_s == Approx(back->end.time_s).epsilon(1e-9));
    if (std::abs(there->end.time_s - back->end.time_s) > 1e-12) continue;
    CHECK(there->sin_phi == Approx(-back->end.sin_phi).margin(1e-7));
    // Reciprocity of the tubes, with which the way there and back is worked out.
    CHECK(tube_area_m2(there->end) * std::pow(sound_speed_at(layers, a), 2) ==
          Approx(tube_area_m2(back->end) * std::pow(sound_speed_at(layers, b), 2)).epsilon(1e-5));
    // Fermat: no straight way is faster than the fastest.
    double straight = 0;
    const int n = 2000;
    for (int k = 0; k < n; ++k) {
      straight += std::hypot(x, b - a) / n / sound_speed_at(layers, a + (b - a) * (k + 0.5) / n);
    }
    CHECK(there->end.time_s <= straight * (1 + 1e-6));
  }
  CHECK(found > 280);
}

// Protects the time to a target in one gradient, which is a closed form of its ends alone.
TEST_CASE("an eigenray in one gradient has the time of its ends") {
  const SoundLayers layers = one_gradient(kGradient);
  for (const double x : {1e-12, 1e-5, 0.5, 20.0, 55.0}) {
    for (const double z : {-30.0, -0.1, 0.0, 18.0}) {
      if (x < 1e-6 && z == 0) continue;
      const auto ray = find_eigenray(layers, 0, x, z);
      INFO(x << " " << z);
      REQUIRE(ray);
      const double c = 1500 + kGradient * z;
      const double time =
          2 / kGradient * std::asinh(kGradient * std::hypot(x, z) / (2 * std::sqrt(1500 * c)));
      CHECK(ray->end.time_s == Approx(time).epsilon(1e-11));
    }
  }
}

// Protects what is heard: where no ray comes, nothing is.
TEST_CASE("a point in the shadow zone has no eigenray") {
  // Fastest at 20 m: rays part above and below. The last ones graze that depth.
  const SoundLayers layers = make_layers({0, {0, 20, 40}, {1460, 1500, 1460}});
  CHECK(find_eigenray(layers, -15, 10, -17));
  CHECK_FALSE(find_eigenray(layers, -15, 300, -20.5));
  CHECK(find_eigenray(layers, -15, 100, -5));
}

// Protects the channel's axis, on which a ray can go neither up nor down.
TEST_CASE("a ray along the axis of a channel stays there") {
  const SoundLayers layers = make_layers({0, {0, 20, 40}, {1540, 1500, 1540}});
  const RayPoint along = follow(layers, -20, 0, 500);
  CHECK(along.z_m == Approx(-20).margin(1e-8));
  CHECK(along.time_s == Approx(500.0 / 1500).epsilon(1e-10));
  const RayPoint near = follow(layers, -20 + 1e-12, 1e-9, 500);
  CHECK(near.z_m == Approx(-20).margin(1e-8));
  CHECK(near.x_m == Approx(500).epsilon(1e-10));
  // Held in the channel: a steeper one swings about it.
  const RayPoint swings = follow(layers, -20, 0.05, 500);
  CHECK(std::abs(swings.z_m + 20) < 1500 / 2 * (1 / std::cos(0.05) - 1) + 1e-9);
}

// Protects levels at caustics: loud, but finite, and not where nothing is focused.
TEST_CASE("spreading is limited at caustics alone") {
  RayPoint point;
  point.speed_m_s = 1500;
  point.lateral_m = point.spread_m = 20;
  CHECK(two_way_spreading_m2(point, 1500, 900e3) == 400);
  point.spread_m = 0;
  const double limit = 400 / std::cbrt(2 * kPi * 900e3 / 1500 * 20);
  CHECK(two_way_spreading_m2(point, 1500, 900e3) == Approx(limit).epsilon(1e-12));
  point.spread_m = -20;
  CHECK(two_way_spreading_m2(point, 1515, 900e3) == Approx(404).epsilon(1e-12));
}

// Protects data sets without a profile, or with one that says what the instrument thinks.
TEST_CASE("only another speed bends") {
  Water water{1500, 0.3};
  CHECK_FALSE(bends(water));
  water.profile = SoundProfile{0, {0, 10}, {1500, 1500}};
  CHECK_FALSE(bends(water));
  water.profile->speed_m_s[1] = 1500.001;
  CHECK(bends(water));
  CHECK(sound_speed_at(make_layers(*water.profile), -5) == Approx(1500.0005).epsilon(1e-12));
  CHECK(sound_speed_at(make_layers(*water.profile), 3) == 1500);
  CHECK(sound_speed_at(make_layers(*water.profile), -11) == 1500.001);
}
