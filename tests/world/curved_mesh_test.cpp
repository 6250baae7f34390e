// Smooth bodies of coarse meshes, against the spheres and cylinders that they stand for.
#include "world/curved_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "catch.h"
#include "core/units.h"
#include "is_refused.h"
#include "round_meshes.h"
#include "scenes.h"
#include "temporary_folder.h"
#include "world/world.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr double kWavelength_m = 1e-3;

Mesh smooth(const Mesh& mesh, double wavelength_m = kWavelength_m) {
  Result<Mesh> curved = curved_mesh(mesh, wavelength_m);
  REQUIRE(curved.ok());
  return std::move(*curved);
}

double around_z(Vec3 p) { return std::hypot(p.x, p.y); }

// The largest distance between middles of faces and a surface, by its distance from there.
template <class Distance>
double worst_face(const Mesh& mesh, Distance distance) {
  double worst = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 middle = (1.0 / 3) * (to_vec3(mesh.vertices[a]) + to_vec3(mesh.vertices[b]) +
                                     to_vec3(mesh.vertices[c]));
    worst = std::max(worst, std::abs(distance(middle)));
  }
  return worst;
}

// How many sides do not have exactly one partner that runs the other way, between equal places.
int open_sides(const Mesh& mesh) {
  std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> sides;
  for (const auto& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      ++sides[{mesh.vertices[triangle[i]], mesh.vertices[triangle[(i + 1) % 3]]}];
    }
  }
  return static_cast<int>(std::ranges::count_if(sides, [&](const auto& side) {
    const auto back = sides.find({side.first.second, side.first.first});
    return side.second != 1 || back == sides.end();
  }));
}

}  // namespace

TEST_CASE("a coarse ball becomes a sphere") {
  const double radius_m = 0.3;
  const Mesh coarse = ball_mesh(radius_m);
  CHECK(coarse.triangles.size() == 320);
  const auto from_sphere = [&](Vec3 p) { return length(p) - radius_m; };
  // At this wavelength all sides are divided once, so that every vertex is one of the formula.
  const Mesh finer = smooth(coarse, 0.128);
  CHECK(finer.triangles.size() == 4 * 320);
  for (std::size_t v = 0; v < finer.vertices.size(); ++v) {
    const Vec3 place = to_vec3(finer.vertices[v]);
    REQUIRE(std::abs(from_sphere(place)) < 1e-7);
    REQUIRE(length(normalized(place) - to_vec3(finer.normals[v])) < 1e-5);
  }
  CHECK(worst_face(coarse, from_sphere) > 1e-3);
  CHECK(worst_face(smooth(coarse), from_sphere) < 2 * kSag_wavelengths * kWavelength_m);
  CHECK(open_sides(finer) == 0);
}

// Protects meshes of scanned or joined parts, whose faces turn either way around.
TEST_CASE("a ball is a sphere, whichever way its faces turn") {
  Mesh mesh = ball_mesh(0.3);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += t % 3 + 1) {
    std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  }
  const Mesh finer = smooth(mesh, 0.128);
  CHECK(finer.triangles.size() == 4 * 320);
  for (const auto& v : finer.vertices) REQUIRE(length(to_vec3(v)) == Approx(0.3).margin(1e-7));
  CHECK(open_sides(finer) == 0);
}

TEST_CASE("a coarse cylinder becomes round, and its rims stay sharp") {
  const double radius_m = 0.5, height_m = 0.8;
  for (const bool closed : {false, true}) {
    INFO(closed);
    const Mesh fine = smooth(prism_mesh(radius_m, height_m, 96, closed));
    for (const auto& v : fine.vertices) {
      const Vec3 p = to_vec3(v);
      const bool on_side =
          std::abs(around_z(p) - radius_m) < 1e-6 && std::abs(p.z) < height_m / 2 + 1e-6;
      const bool on_lid =
          std::abs(std::abs(p.z) - height_m / 2) < 1e-6 && around_z(p) < radius_m + 1e-6;
      REQUIRE((on_side || (closed && on_lid)));
    }
  }
}

// The rim is common to side and lid, whose own bodies would not meet there: 24 segments depart by 4
// mm. With one division for all sides, every new side has its partner.
TEST_CASE("no gap opens along an edge of the body") {
  Mesh mesh = prism_mesh(0.5, 0.05, 24, true);
  CHECK(open_sides(mesh) == 0);
  const Mesh fine = smooth(mesh, 0.16);
  CHECK(fine.triangles.size() > mesh.triangles.size());
  double side_m2 = 0, lid_m2 = 0;
  for (const auto& [a, b, c] : fine.triangles) {
    const Vec3 from = to_vec3(fine.vertices[a]);
    const Vec3 area =
        0.5 * cross(to_vec3(fine.vertices[b]) - from, to_vec3(fine.vertices[c]) - from);
    (std::abs(area.z) > 0.5 * length(area) ? lid_m2 : side_m2) += length(area);
  }
  // Within the chords of the finer polygon, which lack 2/3 of their sag.
  CHECK(lid_m2 == Approx(2 * kPi * 0.25).epsilon(0.005));
  CHECK(side_m2 == Approx(2 * kPi * 0.5 * 0.05).epsilon(0.005));
}

TEST_CASE("flat bodies stay as they are") {
  Mesh box;
  for (int i = 0; i < 8; ++i) {
    box.vertices.push_back({i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f});
  }
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  // Smooth ones, as an exporter writes them for a box too.
  for (const auto& v : box.vertices) box.normals.push_back(to_floats(normalized(to_vec3(v))));
  CHECK(smooth(box).triangles.size() == 12);
  CHECK(facet_sag(box).sag_m == Approx(0).margin(1e-9));
}

TEST_CASE("the mesh's own normals make a body of eight segments round") {
  Mesh mesh = prism_mesh(0.4, 0.2, 8, false);
  CHECK(smooth(mesh, 0.01).triangles.size() == mesh.triangles.size());
  for (const auto& v : mesh.vertices)
    mesh.normals.push_back(to_floats(normalized(Vec3{v[0], v[1], 0})));
  const Mesh round = smooth(mesh, 0.01);
  for (const auto& v : round.vertices) REQUIRE(around_z(to_vec3(v)) == Approx(0.4).margin(1e-6));
  // Unequal normals on one side of a seam make it an edge.
  Mesh cut = mesh;
  for (auto& n : cut.normals) n = {0, 0, 1};
  CHECK(smooth(cut, 0.01).triangles.size() == mesh.triangles.size());
}

// Its curvature changes along the facets, which the formula knows to second order only.
TEST_CASE("a coarse ellipsoid is followed to a small part of its facets") {
  Mesh mesh = ball_mesh(1);
  for (auto& v : mesh.vertices) v = {0.3f * v[0], 0.2f * v[1], 0.15f * v[2]};
  for (const auto& v : mesh.vertices) {
    mesh.normals.push_back(to_floats(normalized(Vec3{v[0] / 0.09, v[1] / 0.04, v[2] / 0.0225})));
  }
  const auto from_body = [](Vec3 p) {
    const Vec3 scaled{p.x / 0.3, p.y / 0.2, p.z / 0.15};
    const double value = dot(scaled, scaled) - 1;
    return value / (2 * length({p.x / 0.09, p.y / 0.04, p.z / 0.0225}));  // to first order
  };
  CHECK(worst_face(smooth(mesh), from_body) < 0.06 * worst_face(mesh, from_body));
}

TEST_CASE("what belongs to the faces and corners goes with them") {
  Mesh mesh = prism_mesh(0.5, 0.5, 24, false);
  for (const auto& v : mesh.vertices) {
    mesh.reflectivity.push_back(v[2] + 1);
    mesh.uv.push_back({v[2], 2 * v[2]});
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) mesh.part.push_back(t < 24 ? 0 : 1);
  mesh.part_names = {"a", "b"};
  const Mesh fine = smooth(mesh);
  REQUIRE(fine.part.size() == fine.triangles.size());
  CHECK(2 * std::ranges::count(fine.part, 1) == std::ssize(fine.part));
  for (std::size_t v = 0; v < fine.vertices.size(); ++v) {
    REQUIRE(fine.reflectivity[v] == Approx(fine.vertices[v][2] + 1).margin(1e-6));
    REQUIRE(fine.uv[v][1] == Approx(2 * fine.vertices[v][2]).margin(1e-6));
  }
}

TEST_CASE("a body that needs too many triangles is refused") {
  CHECK(is_refused(curved_mesh(ball_mesh(100), 1e-4), "million"));
}

// Protects the rule: mirrors with smooth normals are made round, those with face normals are warned
// of, and other materials keep their mesh.
TEST_CASE("only bodies with a specular echo are made round") {
  const TemporaryFolder folder;
  std::string text;
  const Mesh prism = prism_mesh(0.5, 0.5, 48, false);
  for (const auto& v : prism.vertices) {
    text += "v " + std::to_string(v[0]) + " " + std::to_string(v[1]) + " " + std::to_string(v[2]) +
            "\n";
  }
  for (const auto& t : prism.triangles) {
    text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
            std::to_string(t[2] + 1) + "\n";
  }
  const auto file = folder.write("prism.obj", text);
  const auto built_of = [&](bool mirror, bool smooth_normals) {
    Scenario scenario = scenario_of_shapes({MeshSpec{file, {1, 1, 1}, smooth_normals, false}});
    scenario.sonar.frequency_hz = 1e6;
    if (mirror) scenario.materials[0].coherent = KirchhoffSpec{};
    return built(scenario);
  };
  CHECK(mesh_of(built_of(true, true), 0)->triangles.size() > 1000);
  CHECK(mesh_of(built_of(false, true), 0)->triangles.size() == 96);
  CHECK(built_of(false, false).warnings.empty());
  // All sonars of a rig hear one body, as round as the highest frequency needs.
  Scenario rig = scenario_of_shapes({MeshSpec{file, {1, 1, 1}, true, false}});
  rig.materials[0].coherent = KirchhoffSpec{};
  rig.rig.resize(2);
  rig.rig[0].sonar.emplace();
  rig.rig[1].sonar.emplace().frequency_hz = 1e6;
  CHECK(mesh_of(built(rig), 0)->triangles.size() ==
        mesh_of(built_of(true, true), 0)->triangles.size());
  const World faceted = built_of(true, false);
  CHECK(mesh_of(faceted, 0)->triangles.size() == 96);
  REQUIRE(faceted.warnings.size() == 1);
  CHECK(
      faceted.warnings[0].starts_with("objects.0.shape.mesh.normals: the material has a specular "
                                      "echo, and each facet of the mesh is a "
                                      "mirror of its own: sides of 0.065 m stand for a body with a "
                                      "radius of 0.5 m, which needs sides "
                                      "of at most 0.013 m at 1000 kHz"));
}

// Protects what is straight: the long mantle of a body with a conical end does not become a barrel.
TEST_CASE("a wide face beside a narrow one stays straight") {
  const double radius_m = 0.2, length_m = 1, cone_m = 0.02;
  Mesh mesh = prism_mesh(radius_m, length_m, 24, false);
  // A ring of cones, at 20 degrees, above the upper rim.
  const double upper_m = radius_m - cone_m * std::tan(radians(20));
  for (std::uint32_t i = 0; i < 24; ++i) {
    const double angle = 2 * kPi * i / 24;
    add_vertex(mesh, {upper_m * std::cos(angle), upper_m * std::sin(angle), length_m / 2 + cone_m});
  }
  for (std::uint32_t i = 0; i < 24; ++i) {
    const std::uint32_t k = (i + 1) % 24;
    mesh.triangles.insert(mesh.triangles.end(),
                          {{24 + i, 24 + k, 48 + k}, {24 + i, 48 + k, 48 + i}});
  }
  for (const auto& v : smooth(mesh).vertices) {
    const Vec3 p = to_vec3(v);
    if (p.z <= length_m / 2) REQUIRE(around_z(p) == Approx(radius_m).margin(2e-5));
  }
}
