// Protects: the echoes of sharp edges. Their sum against line integrals, which edges of which shapes
// give them, what hides them, and that neither frames nor threads change them.
#include "trace/edges.h"

#include <cmath>
#include <complex>

#include "acoustics/pattern.h"
#include "acoustics/scattering.h"
#include "catch.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "trace/plain_world.h"
#include "trace/scatter.h"
#include "trace/scene.h"

namespace ensonify {
namespace {

constexpr double kEdgeSpeed_m_s = 1500, kEdgeCarrier_hz = 900e3;
constexpr double kEdgeWavelength_m = kEdgeSpeed_m_s / kEdgeCarrier_hz;
const Water kEdgeWater{kEdgeSpeed_m_s, 0};

Sonar narrow_sonar() { return test::fan_sonar(64, radians(40), 12, 40, radians(30)); }

Material with_edges(double reflection = 1, double roughness_m = 0) {
  Material material;
  material.coherent = CoherentModel::kirchhoff;
  material.reflection = reflection;
  material.roughness_rms_m = roughness_m;
  material.edges = true;
  return material;
}

World edged_body(Shape shape, Pose pose, const Material& material = with_edges()) {
  return world_with(std::move(shape), pose, material);
}

std::vector<Scatterer> edge_echoes(const World& world, const Sonar& sonar, int threads = 2) {
  const Tracer tracer(world);
  const std::vector<Pose> poses = own_poses(world);
  return edge_scatterers({world, tracer, poses, {}},
                         make_surface_scattering(sonar, kEdgeWater, world), Workers(threads));
}

template <class Want>
std::complex<double> edge_sum(std::vector<Scatterer> scatterers, double reference_m,
                              const Want& want) {
  std::erase_if(scatterers, [&](const Scatterer& s) { return !want(s); });
  return sum_of_echoes(scatterers, kEdgeCarrier_hz, reference_m);
}

// The fringe of a straight edge from a to b at the angle from one face that `angle_of` gives.
template <class AngleOf>
std::complex<double> line_integral(Vec3 a, Vec3 b, Wedge wedge, double reference_m,
                                   const AngleOf& angle_of) {
  constexpr int kSteps = 40000;
  std::complex<double> sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 p = a + ((i + 0.5) / kSteps) * (b - a);
    const double r = length(p);
    sum += fringe_diffraction(wedge, angle_of(p)) / (r * r) *
           std::polar(1.0, -4 * kPi / kEdgeWavelength_m * (r - reference_m));
  }
  return length(b - a) / kSteps / (2 * kPi) * sum;
}

// An upright box turned by 45 degrees shows its near edge with both faces at 45 degrees.
TEST_CASE("the near edge of a box sums up to its line integral") {
  constexpr double kSide_m = 0.3, kNear_m = 4;
  const double half_diagonal = kSide_m / std::sqrt(2.0);
  const Quat turn{std::cos(kPi / 8), 0, 0, std::sin(kPi / 8)};
  const auto echo = [&](double reflection, double roughness_m = 0) {
    const World world = edged_body(BoxShape{{kSide_m / 2, kSide_m / 2, 0.4}, false},
                             {{kNear_m + half_diagonal, 0, 0}, turn},
                             with_edges(reflection, roughness_m));
    const auto near = [&](const Scatterer& s) {
      return std::hypot(s.position_m.x - kNear_m, s.position_m.y) < 1e-3;
    };
    return edge_sum(edge_echoes(world, narrow_sonar()), kNear_m, near);
  };
  const auto middle = [](Vec3) { return radians(135); };
  const Vec3 low{kNear_m, 0, -0.4}, high{kNear_m, 0, 0.4};
  const auto rigid = line_integral(low, high, {1.5 * kPi, true}, kNear_m, middle);
  const auto soft = line_integral(low, high, {1.5 * kPi, false}, kNear_m, middle);
  CHECK(std::abs(echo(1) - rigid) < 0.01 * std::abs(rigid));
  CHECK(std::abs(echo(-0.5) - 0.5 * soft) < 0.01 * std::abs(soft));
  // e^(-2 k^2 h^2 cos^2 45 deg) in the middle of the edge, where most of the echo comes from.
  const double kh = 2 * kPi / kEdgeWavelength_m * 1e-4;
  CHECK(std::abs(echo(1, 1e-4)) ==
        Approx(std::abs(rigid) * std::exp(-kh * kh)).epsilon(0.01));
}

// The plate's back edges lie in its shadow, and its far and near edges are seen.
TEST_CASE("an oblique plate shows the edges that the sonar sees") {
  const double turn = radians(30);
  const World plate = edged_body(BoxShape{{0.05, 0.2, 0.2}, false},
                           {{4, 0, 0}, {std::cos(turn / 2), 0, 0, std::sin(turn / 2)}});
  const auto scatterers = edge_echoes(plate, narrow_sonar());
  const auto at = [&](double x, double y) {
    const Vec3 place = transform_point(plate.objects[0].pose, {x, y, 0});
    return std::count_if(scatterers.begin(), scatterers.end(), [&](const Scatterer& s) {
      return std::hypot(s.position_m.x - place.x, s.position_m.y - place.y) < 1e-3;
    });
  };
  CHECK(at(-0.05, 0.2) > 50);
  CHECK(at(-0.05, -0.2) > 50);
  // One of the rear edges is seen along the side that faces the sonar, and the other one is not.
  CHECK((at(0.05, 0.2) > 50) != (at(0.05, -0.2) > 50));
}

TEST_CASE("both rims of a cylinder, and of the same cylinder as a mesh") {
  constexpr double kRadius_m = 0.1, kHalf_m = 0.05, kRange_m = 4;
  const Pose end_on{{kRange_m + kHalf_m, 0, 0}, {std::sqrt(0.5), 0, std::sqrt(0.5), 0}};
  const auto near = [&](const Scatterer& s) { return s.position_m.x < kRange_m + 0.01; };
  const auto exact = edge_sum(edge_echoes(edged_body(CylinderShape{kRadius_m, kHalf_m}, end_on),
                                      narrow_sonar()), kRange_m, near);
  // All of the rim is as far away, and lies at the angle psi off axis from the middle.
  const double psi = std::atan(kRadius_m / kRange_m), r = std::hypot(kRadius_m, kRange_m);
  const auto expected = kRadius_m * fringe_diffraction({1.5 * kPi, true}, kPi / 2 - psi) /
                        (r * r) *
                        std::polar(1.0, -4 * kPi / kEdgeWavelength_m * (r - kRange_m));
  CHECK(std::abs(exact - expected) < 0.02 * std::abs(expected));

  auto mesh = std::make_shared<Mesh>();
  constexpr std::uint32_t kCorners = 2000;
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    const double a = 2 * kPi * i / kCorners;
    for (const double z : {-kHalf_m, kHalf_m}) {
      mesh->vertices.push_back(to_floats({kRadius_m * std::cos(a), kRadius_m * std::sin(a), z}));
    }
  }
  mesh->vertices.push_back({0, 0, static_cast<float>(-kHalf_m)});
  mesh->vertices.push_back({0, 0, static_cast<float>(kHalf_m)});
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % kCorners);
    mesh->triangles.push_back({a, b, b + 1});
    mesh->triangles.push_back({a, b + 1, a + 1});
    mesh->triangles.push_back({b, a, 2 * kCorners});
    mesh->triangles.push_back({a + 1, b + 1, 2 * kCorners + 1});
  }
  const auto faceted =
      edge_sum(edge_echoes(edged_body(MeshShape{mesh}, end_on), narrow_sonar()), kRange_m, near);
  CHECK(std::abs(faceted - exact) < 0.03 * std::abs(exact));
}

std::shared_ptr<Mesh> mesh_of(std::vector<std::array<float, 3>> vertices,
                              std::vector<std::array<std::uint32_t, 3>> triangles) {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = std::move(vertices);
  mesh->triangles = std::move(triangles);
  return mesh;
}

TEST_CASE("an open sheet has a rim, and a smooth fold or a notch seen from inside has no edge") {
  const Sonar sonar = narrow_sonar();
  // A square in the plane x = 4 as two triangles with corners of their own.
  const auto square = mesh_of({{4, -0.2f, -0.2f}, {4, 0.2f, -0.2f}, {4, 0.2f, 0.2f},
                               {4, -0.2f, -0.2f}, {4, 0.2f, 0.2f}, {4, -0.2f, 0.2f}},
                              {{0, 1, 2}, {3, 4, 5}});
  const auto bodies = diffracting_edges(edged_body(MeshShape{square}, {}), kEdgeWavelength_m);
  REQUIRE(bodies.size() == 1);
  CHECK(bodies[0].edges.size() == 4);
  CHECK(bodies[0].edges[0].is_rim());
  const auto rim = edge_echoes(edged_body(MeshShape{square}, {}), sonar);
  CHECK(rim.size() > 300);

  // A fold of 30 degrees; one of 90 degrees away from the sonar and one toward it.
  const auto fold = [](float x) {
    return mesh_of({{4, 0, -0.2f}, {4, 0, 0.2f}, {x, -0.2f, 0}, {x, 0.2f, 0}},
                   {{0, 1, 2}, {1, 0, 3}});
  };
  const auto ridge_echoes = [&](float x) {
    const auto all = edge_echoes(edged_body(MeshShape{fold(x)}, {}), sonar);
    return std::count_if(all.begin(), all.end(), [](const Scatterer& s) {
      return std::abs(s.position_m.y) < 1e-9 && std::abs(s.position_m.z) < 0.19;
    });
  };
  CHECK(ridge_echoes(4 + 0.2f * std::tan(0.26f)) == 0);
  CHECK(ridge_echoes(4.2f) > 50);
  CHECK(ridge_echoes(3.8f) == 0);
}

TEST_CASE("what stands in front hides an edge, and rooms and plain materials have none") {
  const Sonar sonar = narrow_sonar();
  const BoxShape box{{0.1, 0.1, 0.1}, false};
  World world = edged_body(box, {{4, 0, 0}, {}});
  const auto seen = edge_echoes(world, sonar);
  CHECK_FALSE(seen.empty());
  add_object(world, BoxShape{{0.01, 0.3, 0.3}, false}, {{3, 0, 0}, {}});
  CHECK(edge_echoes(world, sonar).empty());
  CHECK(edge_echoes(edged_body(BoxShape{{5, 5, 5}, true}, {{4, 0, 0}, {}}), sonar).empty());
  CHECK(edge_echoes(edged_body(SphereShape{0.2, false}, {{4, 0, 0}, {}}), sonar).empty());
  Material smooth = with_edges();
  smooth.edges = false;
  CHECK(diffracting_edges(edged_body(box, {{4, 0, 0}, {}}, smooth), kEdgeWavelength_m).empty());

  const auto alone = edge_echoes(edged_body(box, {{4, 0, 0}, {}}), sonar, 1);
  REQUIRE(alone.size() == seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    CHECK(alone[i].key == seen[i].key);
    CHECK(alone[i].mean == seen[i].mean);
  }
}

// Protects meshes that objects share: the second one may have parts of other materials.
TEST_CASE("edges follow the parts of each object, not of the first one with the mesh") {
  const auto square = mesh_of({{4, -0.2f, -0.2f}, {4, 0.2f, -0.2f}, {4, 0.2f, 0.2f}}, {{0, 1, 2}});
  square->part = {0};
  World world = edged_body(MeshShape{square}, {});
  Material dull = with_edges();
  dull.edges = false;
  add_object(world, MeshShape{square}, {{0, 0, 1}, {}}, with_edges());
  world.objects[1].parts = {{1}, {dull}};
  const auto echoes = edge_echoes(world, narrow_sonar());
  REQUIRE_FALSE(echoes.empty());
  for (const Scatterer& s : echoes) CHECK(s.instance == 1);
}

// Protects against as many pieces as a long edge has, most of them beyond the range.
TEST_CASE("an edge is cut only where it is within range") {
  const Vec3 eye{0, 0, 0};
  const Line line{{2, 0, 0}, {0, 1e7, 0}};
  const auto near = within_range(line, eye, 12);
  REQUIRE(near);
  CHECK(length(near->middle_m + near->half_m) == Approx(12).epsilon(1e-6));
  CHECK(near->length_m() == Approx(2 * std::sqrt(140)).epsilon(1e-6));
  CHECK(pieces_of(*near, eye, narrow_sonar(), kEdgeWater) < 100'000);
  CHECK_FALSE(within_range({{13, 0, 0}, {0, 1e7, 0}}, eye, 12));
  CHECK_FALSE(within_range({{0, 30, 0}, {0, 10, 0}}, eye, 12));
  const auto all = edge_echoes(edged_body(BoxShape{{1, 1e7, 0.2}, false}, {{4, 0, 0}, {}}),
                               narrow_sonar());
  CHECK(all.size() > 1000);
}

}  // namespace
}  // namespace ensonify
