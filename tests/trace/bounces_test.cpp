// Paths over several surfaces: corners against a quadrature of their own, a plate over a plane against the image
// method. Small corners and the closed Lambert sphere, V21 and V23, are in tests/verification/bounces.py.
#include "trace/bounces.h"

#include <cmath>
#include <complex>
#include <functional>
#include <map>
#include <memory>
#include <set>

#include "catch.h"
#include "core/units.h"
#include "mirrored_sea.h"
#include "sonar_fixture.h"
#include "trace/mirror_chains.h"
#include "trace/plain_world.h"

using namespace ensonify;

namespace {

constexpr double kBounceSpeed_m_s = 1500, kCornerRange_m = 5;
const Water kClearWater{kBounceSpeed_m_s, 0};

Material smooth_material() {
  Material material;
  material.coherent = CoherentModel::kirchhoff;
  material.reflection = 1;
  return material;
}

Material lambert_wall(double albedo) {
  Material material;
  material.reflectivity = albedo / kPi;
  return material;
}

using Corner = std::array<Vec3, 3>;

// A mesh of single triangles in the sonar's frame.
World facets(const std::vector<Corner>& triangles, const Material& material) {
  auto mesh = std::make_shared<Mesh>();
  for (const Corner& corner : triangles) {
    const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
    for (const Vec3& p : corner) mesh->vertices.push_back(to_floats(p));
    mesh->triangles.push_back({first, first + 1, first + 2});
  }
  return world_with(MeshShape{mesh}, {}, material);
}

// Two plates that meet at right angles in an upright edge ahead, open towards the sonar.
std::vector<Corner> dihedral(double side_m, double height_m) {
  const double d = side_m / std::sqrt(2.0), h = height_m / 2;
  std::vector<Corner> all;
  for (const double y : {d, -d}) {
    const Vec3 low{kCornerRange_m, 0, -h}, high{kCornerRange_m, 0, h};
    const Vec3 out_low{kCornerRange_m - d, y, -h}, out_high{kCornerRange_m - d, y, h};
    all.push_back({low, out_low, out_high});
    all.push_back({low, out_high, high});
  }
  return all;
}

// Three squares at right angles, of sides of `leg_m` from an apex ahead, their axis towards the sonar.
std::vector<Corner> trihedral(double leg_m) {
  const Vec3 apex{kCornerRange_m, 0, 0};
  std::array<Vec3, 3> leg;
  for (int i = 0; i < 3; ++i) {
    const double turn = 2 * kPi * i / 3;
    leg[i] = leg_m * Vec3{-1 / std::sqrt(3.0), std::sqrt(2.0 / 3) * std::cos(turn),
                          std::sqrt(2.0 / 3) * std::sin(turn)};
  }
  std::vector<Corner> all;
  for (int i = 0; i < 3; ++i) {
    const Vec3 a = leg[i], b = leg[(i + 1) % 3];
    all.push_back({apex, apex + a, apex + b});
    all.push_back({apex + a, apex + a + b, apex + b});
  }
  return all;
}

Sonar narrow_fan(double degrees, int cells) {
  Sonar sonar = test::fan_sonar(cells, radians(degrees), 12, cells, radians(degrees));
  sonar.elevation_width_rad = radians(60);
  return sonar;
}

std::vector<Scatterer> bounced(const World& world, const Sonar& sonar, int bounces,
                               bool ways_as_one = true, int threads = 2, std::uint32_t ping = 0) {
  const Tracer tracer(world);
  const Fan fan = make_fan(sonar);
  const Workers workers(threads);
  const auto hits = tracer.trace_fan(fan, {}, sonar.range_max_m, workers);
  const SurfaceScattering scattering = make_surface_scattering(sonar, kClearWater, world);
  return bounced_off_surfaces(
      {tracer, world.volumes, {}, scattering, bounces, ways_as_one, 7, ping}, fan, hits, workers);
}

// At the carrier; the elevation pattern is about 1 here.
std::complex<double> coherent_sum(const std::vector<Scatterer>& echoes, const Sonar& sonar) {
  return sum_of_echoes(echoes, sonar.frequency_hz, kCornerRange_m, radians(1e6));
}

double corner_db(const std::vector<Corner>& corner, const Sonar& sonar, int bounces) {
  const World world = facets(corner, smooth_material());
  return 20 * std::log10(std::abs(coherent_sum(bounced(world, sonar, bounces), sonar)) *
                         kCornerRange_m * kCornerRange_m);
}

double bounced_energy(const Scatterer& s) {
  return double{s.gain} * s.gain * s.standard_deviation * s.standard_deviation;
}

// By an independent route: the sonar's image in the one plate shines on the other one, where the
// Kirchhoff integral is taken by the rule of middles; both plates are alike.
double dihedral_integral_db(double side_m, double height_m, double wavelength_m) {
  const int n = 1500;
  const double k = 2 * kPi / wavelength_m, d = 1 / std::sqrt(2.0);
  // Plate 1 lies along (-d, d), plate 2 along (-d, -d); the image of the origin in plate 1.
  const Vec3 image{kCornerRange_m, kCornerRange_m, 0};
  std::complex<double> sum = 0;
  for (int i = 0; i < n; ++i) {
    const double u = side_m * (i + 0.5) / n;
    const double x = kCornerRange_m - d * u, y = -d * u;
    // Where the straight line from the image crosses plate 1: its height does not matter on it.
    const double t = (kCornerRange_m - image.x - image.y) / ((x - image.x) + (y - image.y));
    const double along = (image.y + t * (y - image.y)) / d;
    if (!(along >= 0 && along <= side_m)) continue;
    for (int j = 0; j < n / 10; ++j) {
      const double z = height_m * ((j + 0.5) / (n / 10) - 0.5);
      const Vec3 point{x, y, z};
      const double out = length(point - image), back = length(point);
      const Vec3 normal{-d, d, 0};
      const double incidence = std::abs(dot(normal, point - image)) / out;
      const double leaving = std::abs(dot(normal, point)) / back;
      sum += (incidence + leaving) / 2 / (out * back) *
             std::polar(1.0, -k * (out + back - 2 * kCornerRange_m));
    }
  }
  sum *= side_m / n * height_m / (n / 10) / wavelength_m;
  return 20 * std::log10(2 * std::abs(sum) * kCornerRange_m * kCornerRange_m);
}

}  // namespace

TEST_CASE("a dihedral of any size is the integral over its second plate") {
  const double wavelength = kBounceSpeed_m_s / 900e3;
  for (const double side : {0.05, 0.1, 0.2}) {
    CHECK(corner_db(dihedral(side, 0.04), narrow_fan(4, 60), 1) ==
          Approx(dihedral_integral_db(side, 0.04, wavelength)).margin(0.15));
  }
}

TEST_CASE("a large corner is the sonar's image") {
  const Sonar sonar = narrow_fan(12, 60);
  const World world = facets(dihedral(0.8, 0.8), smooth_material());
  const auto echoes = bounced(world, sonar, 1);
  // A disk of many Fresnel zones, less the ripple of its edges.
  CHECK(20 * std::log10(std::abs(coherent_sum(echoes, sonar))) ==
        Approx(-20 * std::log10(2 * kCornerRange_m)).margin(1.5));
  for (const Scatterer& s : echoes) CHECK(s.path == path_of_kinds(2, 0b11));
}

TEST_CASE("a trihedral is heard whichever way it is turned a little") {
  const Sonar sonar = narrow_fan(0.8, 24);
  const double facing = corner_db(trihedral(0.03), sonar, 2);
  std::vector<Corner> turned = trihedral(0.03);
  for (Corner& corner : turned) {
    for (Vec3& p : corner) {
      const Vec3 apex{kCornerRange_m, 0, 0};
      p = apex + rotate(from_roll_pitch_yaw(0, 0, radians(5)), p - apex);
    }
  }
  CHECK(corner_db(turned, sonar, 2) == Approx(facing).margin(1.5));
}

TEST_CASE("a plate over a smooth plane is heard as by the image method") {
  const std::string objects = R"(objects:
  - {name: floor, material: mirror, shape: {plane: {}}, pose: {position_m: [0, 0, -2]}}
  - {name: plate, material: sand, shape: {box: {size_m: [0.2, 3, 2]}}, pose: {position_m: [9, 0, -0.8]}}
)";
  const test::Sea sea(test::head(60, 800) + test::kMaterials + objects +
                      "multipath: {objects: true, bounces: 2}\n");
  const Workers workers(1);
  const auto hits = sea.tracer->trace_fan(sea.fan, {}, sea.sonar.range_max_m, workers);
  const auto expected = bounced_echoes(
      {sea.plan, *sea.world, *sea.tracer, sea.poses, {}, sea.scattering}, sea.fan, hits, workers);
  const auto obtained =
      bounced_off_surfaces({*sea.tracer, sea.world->volumes, {}, sea.scattering, 2, false, 1, 0},
                           sea.fan, hits, workers);
  // The plate by way of the floor, out or back or both; what scatters on to another surface apart.
  const auto sums = [](const std::vector<Scatterer>& echoes, auto kind) {
    std::map<int, double> sum;
    for (const Scatterer& s : echoes) sum[kind(s)] += bounced_energy(s);
    return sum;
  };
  auto image = sums(expected, [&](const Scatterer& s) {
    const SoundPath& path = sea.plan.paths[s.path - 1u];
    return static_cast<int>(2 * path.out.size() + path.back.size());
  });
  auto found = sums(obtained, [](const Scatterer& s) {
    if (s.path == path_of_kinds(2, 0b01)) return 2;   // out by the floor
    if (s.path == path_of_kinds(2, 0b10)) return 1;   // back by the floor
    if (s.path == path_of_kinds(3, 0b101)) return 3;  // both
    return -1;
  });
  for (const int kind : {1, 2, 3}) {
    REQUIRE(image[kind] > 0);
    // The image method takes the straight rays' elements, these those that the floor reflects.
    CHECK(found[kind] == Approx(image[kind]).epsilon(5e-3));
  }
  CHECK(found[1] == Approx(found[2]).epsilon(1e-6));
}

TEST_CASE("both findings of a scattered path have the same energy") {
  // Rays that begin on the one plate against rays that begin on the other one: the departure tells.
  std::vector<Corner> left = dihedral(1, 1), right = {left[2], left[3]};
  left.resize(2);
  World world = facets(left, lambert_wall(0.5));
  add_object(world, facets(right, lambert_wall(0.1)).objects[0].shape, {}, lambert_wall(0.1));
  std::vector<double> difference;
  double mean_sum = 0;
  for (std::uint32_t ping = 0; ping < 60; ++ping) {
    double from_left = 0, from_right = 0;
    const auto echoes = bounced(world, narrow_fan(16, 24), 1, false, 1, ping);
    // Pairs stand one behind the other: the first of each is the way in which it was found.
    for (std::size_t i = 0; i < echoes.size(); i += 2) {
      REQUIRE(echoes[i].key == echoes[i + 1].key);
      CHECK(bounced_energy(echoes[i]) == Approx(bounced_energy(echoes[i + 1])).epsilon(1e-3));
      (echoes[i].departure.azimuth_rad > 0 ? from_left : from_right) += bounced_energy(echoes[i]);
    }
    difference.push_back(from_left - from_right);
    mean_sum += from_left + from_right;
  }
  double mean = 0, variance = 0;
  for (const double d : difference) mean += d / 60;
  for (const double d : difference) variance += (d - mean) * (d - mean) / 59;
  CHECK(std::abs(mean) < 3 * std::sqrt(variance / 60));
  CHECK(std::sqrt(variance / 60) < 0.05 * mean_sum / 60);  // the test can see a tenth
}

TEST_CASE("paths name their instances, and do not depend on threads") {
  World world = facets(dihedral(0.3, 0.3), lambert_wall(0.5));
  add_object(world, BoxShape{{0.05, 2, 2}, false}, {{7, 0, 0}, {}}, lambert_wall(0.5));
  const auto one = bounced(world, narrow_fan(10, 16), 2, true, 1);
  const auto four = bounced(world, narrow_fan(10, 16), 2, true, 4);
  REQUIRE(one.size() == four.size());
  std::set<std::uint64_t> keys;
  for (std::size_t i = 0; i < one.size(); ++i) {
    CHECK(one[i].key == four[i].key);
    CHECK(one[i].gain == four[i].gain);
    CHECK(one[i].via == four[i].via);
    const int surfaces = one[i].path >> 3 ? 3 : 2;
    for (int k = 0; k < kMostBounces; ++k) CHECK((one[i].via[k] != 0) == (k < surfaces - 1));
    keys.insert(one[i].key);
  }
  CHECK(keys.size() > 10);
  CHECK(bounced(world, narrow_fan(10, 16), 0).empty());
}

TEST_CASE("ids of paths are one to one with their kinds") {
  std::set<int> ids;
  for (const SoundPath& path : bounce_paths(kMostBounces, false)) {
    CHECK(ids.insert(path.id).second);
    unsigned kinds = 0;
    for (std::size_t i = 0; i < path.out.size(); ++i) kinds |= (path.out[i] == "specular") << i;
    CHECK(path_of_kinds(static_cast<int>(path.out.size()), kinds) == path.id);
    CHECK(path.back.empty());
  }
  CHECK(ids.size() == 4 + 8 + 16);
  CHECK(bounce_paths(0, false).empty());
}
