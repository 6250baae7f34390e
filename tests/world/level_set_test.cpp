#include "world/mesh.h"

#include <cmath>
#include <set>

#include "catch.h"
#include "scenario/scenario.h"
#include "scenes.h"
#include "temporary_folder.h"
#include "world/world.h"
#include "write_vdb.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr double kRadius = 0.5, kVoxel = 0.05;

Mesh load(const std::filesystem::path& file, Normals normals = Normals::smooth) {
  auto mesh = load_level_set_vdb(file, "", normals);
  INFO((mesh ? "" : mesh.error().message));
  REQUIRE(mesh.ok());
  return std::move(*mesh);
}

std::string fault(const std::filesystem::path& file, const std::string& grid = "") {
  const auto mesh = load_level_set_vdb(file, grid, Normals::face);
  if (mesh) return "";
  CHECK(mesh.error().kind == ErrorKind::usage);
  CHECK(mesh.error().message.starts_with(file.string() + ": "));
  return mesh.error().message.substr(file.string().size() + 2);
}

// By the divergence theorem: above zero where faces are seen counter-clockwise from outside.
double volume_of(const Mesh& mesh) {
  double volume = 0;
  for (const auto& t : mesh.triangles) {
    volume += dot(to_vec3(mesh.vertices[t[0]]),
                  cross(to_vec3(mesh.vertices[t[1]]), to_vec3(mesh.vertices[t[2]]))) /
              6;
  }
  return volume;
}

}  // namespace

// Protects the surface: where the level set has it, to a twentieth of a voxel, which is 1.5 % of
// the volume; outwards, by less than a voxel's turn of the sphere; closed, of the sphere's
// topology.
TEST_CASE("a level set of a sphere is a sphere") {
  const TemporaryFolder folder;
  VdbGrid ball = vdb_sphere(kRadius, kVoxel);
  ball.offset_m = {2, -1, 0.3};
  const auto file = folder.path() / "ball.vdb";
  write_vdb(file, {ball});
  const Mesh mesh = load(file);
  const Vec3 centre{2, -1, 0.3};
  double worst = 0, worst_normal = 1;
  REQUIRE(mesh.normals.size() == mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vec3 out = to_vec3(mesh.vertices[v]) - centre;
    worst = std::max(worst, std::abs(length(out) - kRadius));
    worst_normal = std::min(worst_normal, dot(normalized(out), to_vec3(mesh.normals[v])));
  }
  INFO(worst << " m, cos " << worst_normal);
  CHECK(worst < 0.05 * kVoxel);
  CHECK(worst_normal > std::cos(kVoxel / kRadius));
  CHECK(volume_of(mesh) == Approx(4.0 / 3 * std::acos(-1.0) * std::pow(kRadius, 3)).epsilon(0.015));

  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      INFO("each edge once in either direction");
      REQUIRE(edges.emplace(t[k], t[(k + 1) % 3]).second);
    }
  }
  for (const auto& [a, b] : edges) REQUIRE(edges.contains({b, a}));
  const auto euler = static_cast<long>(mesh.vertices.size()) - static_cast<long>(edges.size() / 2) +
                     static_cast<long>(mesh.triangles.size());
  CHECK(euler == 2);
}

// Protects files from programs that count an axis backwards.
TEST_CASE("a mirrored level set is not inside out") {
  const TemporaryFolder folder;
  VdbGrid ball = vdb_sphere(kRadius, kVoxel);
  ball.mirrored = true;
  write_vdb(folder.path() / "ball.vdb", {ball});
  CHECK(volume_of(load(folder.path() / "ball.vdb", Normals::face)) > 0.5);
}

TEST_CASE("level sets that are none are refused") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.vdb";
  const auto fault_of = [&](VdbGrid grid) {
    write_vdb(file, {std::move(grid)});
    return fault(file);
  };
  VdbGrid fog = vdb_sphere(kRadius, kVoxel);
  fog.kind = VdbKind::fog;
  CHECK(fault_of(fog) ==
        "grid `ball` is a fog volume; expected a level set: densities belong under volumes, "
        "vdb");
  VdbGrid inside_out = vdb_sphere(kRadius, kVoxel);
  inside_out.distance_m = nullptr;
  inside_out.background = -0.15f;
  inside_out.boxes = {{{0, 0, 0}, {3, 3, 3}, 0.1f}};
  CHECK(fault_of(inside_out).starts_with("grid `ball` has the background -0.15"));
  VdbGrid nothing = inside_out;
  nothing.background = 0.15f;
  CHECK(fault_of(nothing).starts_with("grid `ball` has no surface"));
  nothing.boxes = {};
  CHECK(fault_of(nothing).starts_with("grid `ball` has no active voxel"));
  VdbGrid broken = nothing;
  broken.boxes = {{{0, 0, 0}, {3, 3, 3}, std::nanf("")}};
  CHECK(fault_of(broken).starts_with("grid `ball` holds a distance that is not finite"));
  VdbGrid doubles = nothing;
  doubles.kind = VdbKind::doubles;
  CHECK(fault_of(doubles).starts_with("grid `ball` holds double"));
  VdbGrid frustum = vdb_sphere(kRadius, kVoxel);
  frustum.frustum = true;
  CHECK(fault_of(frustum).starts_with("grid `ball` is not a regular grid"));
  CHECK(fault(folder.write("b.vdb", "no grid at all")).starts_with("cannot be read"));
}

TEST_CASE("a grid is chosen by name where there are several") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.vdb";
  VdbGrid small = vdb_sphere(0.3, kVoxel);
  small.name = "small";
  write_vdb(file, {vdb_sphere(kRadius, kVoxel), small});
  CHECK(fault(file) == "holds 2 grids; set `grid` to one of ball, small");
  CHECK(fault(file, "large") == "has no grid `large`; expected one of ball, small");
  const auto mesh = load_level_set_vdb(file, "small", Normals::face);
  REQUIRE(mesh.ok());
  CHECK(length(to_vec3(mesh->vertices[0])) == Approx(0.3).margin(0.01));
  CHECK(mesh->normals.empty());
}

// Protects instancing and the messages' places.
TEST_CASE("objects of one level set share its mesh") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.vdb";
  write_vdb(file, {vdb_sphere(kRadius, kVoxel)});
  const LevelSetSpec smooth{file, "", true}, flat{file, "", false};
  Scenario scenario = scenario_of_shapes({smooth, smooth, flat});
  const World world = built(scenario);
  CHECK(mesh_of(world, 0) == mesh_of(world, 1));
  CHECK(mesh_of(world, 0) != mesh_of(world, 2));
  CHECK(input_files(scenario) == std::vector<std::filesystem::path>{file});
  scenario.objects[1].shape = LevelSetSpec{file, "none", true};
  const auto wrong = build_world(scenario);
  REQUIRE_FALSE(wrong.ok());
  CHECK(wrong.error().message.starts_with("objects.1.shape.level_set.file: " + file.string()));
}
