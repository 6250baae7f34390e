#include "world/terrain.h"

#include <cmath>

#include "catch.h"
#include "grid_texts.h"
#include "is_refused.h"
#include "scenario/scenario.h"
#include "scenes.h"
#include "temporary_folder.h"
#include "world/world.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

const double kHole = std::nan("");

Vec3 vertex(const Mesh& mesh, std::uint32_t index) { return to_vec3(mesh.vertices.at(index)); }

// Twice the triangle's area, as a vector along its normal.
Vec3 area_vector(const Mesh& mesh, const std::array<std::uint32_t, 3>& t) {
  const Vec3 a = vertex(mesh, t[0]);
  return cross(vertex(mesh, t[1]) - a, vertex(mesh, t[2]) - a);
}

HeightGrid grid_of(int rows, int columns, double cell_m, double (*height)(double, double)) {
  HeightGrid grid{rows, columns, cell_m, std::vector<double>(std::size_t(rows) * columns)};
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      grid.heights_m[std::size_t(row) * columns + column] =
          height(column_x_m(grid, column), row_y_m(grid, row));
    }
  }
  return grid;
}

}  // namespace

// Protects the surface: every cell covered once, all faces up, all vertices on the heights.
TEST_CASE("a grid becomes a closed sheet of triangles that face up") {
  const HeightGrid grid = grid_of(7, 11, 0.5, [](double x, double y) { return x * y + x; });
  const Mesh mesh = heightfield_mesh(grid, Normals::face);
  CHECK(mesh.vertices.size() == 77);
  CHECK(mesh.triangles.size() == 2 * 6 * 10);
  CHECK(mesh.normals.empty());
  CHECK(mesh.reflectivity.empty());
  double area = 0;
  for (const auto& triangle : mesh.triangles) {
    CHECK(area_vector(mesh, triangle).z == 0.25);
    area += area_vector(mesh, triangle).z / 2;
  }
  CHECK(area == 15);
  for (std::uint32_t i = 0; i < 77; ++i) {
    const Vec3 v = vertex(mesh, i);
    CHECK(v.z == v.x * v.y + v.x);
  }
}

// Protects ridges: a cell is folded along the diagonal whose ends are nearer in height.
TEST_CASE("a cell is parted along its flatter diagonal") {
  const auto shares_edge = [](const Mesh& mesh, std::uint32_t a, std::uint32_t b) {
    int count = 0;
    for (const auto& t : mesh.triangles) {
      const auto has = [&](std::uint32_t v) { return t[0] == v || t[1] == v || t[2] == v; };
      count += has(a) && has(b);
    }
    return count == 2;
  };
  CHECK(shares_edge(heightfield_mesh({2, 2, 1, {1, 0, 0, 1}}, Normals::face), 0, 3));
  CHECK(shares_edge(heightfield_mesh({2, 2, 1, {0, 1, 1, 0.5}}, Normals::face), 1, 2));
}

TEST_CASE("a hole takes the triangles that it is a corner of") {
  for (int corner = 0; corner < 4; ++corner) {
    HeightGrid cell{2, 2, 1, {0, 1, 5, 2}};
    cell.heights_m[corner] = kHole;
    const Mesh mesh = heightfield_mesh(cell, Normals::smooth);
    CHECK(mesh.vertices.size() == 3);
    CHECK(mesh.normals.size() == 3);
    REQUIRE(mesh.triangles.size() == 1);
    CHECK(area_vector(mesh, mesh.triangles[0]).z == 1);
  }
  HeightGrid grid = grid_of(5, 5, 1, [](double, double) { return 0.0; });
  grid.heights_m[12] = kHole;
  double area = 0;
  const Mesh mesh = heightfield_mesh(grid, Normals::face);
  for (const auto& triangle : mesh.triangles) area += area_vector(mesh, triangle).z / 2;
  CHECK(area == 14);  // of 16: half of each of the four cells around the hole
}

// Protects smooth shading: central differences are exact for a parabola, one-sided ones for a
// plane.
TEST_CASE("smooth normals are those of the surface") {
  const auto check = [](const Mesh& mesh, std::uint32_t i, double slope_x, double slope_y) {
    const Vec3 n = normalized(Vec3{-slope_x, -slope_y, 1});
    CHECK(mesh.normals[i][0] == Approx(n.x).margin(1e-6));
    CHECK(mesh.normals[i][1] == Approx(n.y).margin(1e-6));
    CHECK(mesh.normals[i][2] == Approx(n.z).margin(1e-6));
  };
  const Mesh bowl = heightfield_mesh(
      grid_of(5, 5, 0.5, [](double x, double y) { return x * x - 0.5 * y * y; }), Normals::smooth);
  for (const std::uint32_t i : {6u, 7u, 8u, 11u, 12u, 13u, 16u, 17u, 18u}) {
    const Vec3 v = vertex(bowl, i);
    check(bowl, i, 2 * v.x, -v.y);
  }
  HeightGrid grid = grid_of(5, 5, 0.5, [](double x, double y) { return 0.3 * x - 0.7 * y; });
  grid.heights_m[12] = kHole;
  const Mesh plane = heightfield_mesh(grid, Normals::smooth);
  for (std::uint32_t i = 0; i < 24; ++i) check(plane, i, 0.3, -0.7);
}

// Protects painted ground: corners on corners, straight lines between.
TEST_CASE("a reflectivity map is laid over the whole grid") {
  const TemporaryFolder folder;
  const HeightGrid grid = grid_of(3, 5, 1, [](double, double) { return 0.0; });
  const auto map = vertex_reflectivity(
      folder.write("m.npy", npy("<f4", 2, 3, std::vector<float>{0, 1, 4, 2, 3, 6})), grid);
  REQUIRE(map.ok());
  CHECK(*map == std::vector<float>{0, 0.5f, 1, 2.5f, 4, 1, 1.5f, 2, 3.5f, 5, 2, 2.5f, 3, 4.5f, 6});
  CHECK(heightfield_mesh(grid, Normals::face, *map).reflectivity == *map);
  const std::vector<std::uint16_t> deep = {0, 65535, 0, 65535};
  const auto grey =
      vertex_reflectivity(folder.write("m.png", png(deep.data(), 2, 2, PNG_FORMAT_LINEAR_Y)), grid);
  REQUIRE(grey.ok());
  CHECK(std::vector<float>(grey->begin(), grey->begin() + 5) ==
        std::vector<float>{0, 0.25f, 0.5f, 0.75f, 1});
  const auto negative = vertex_reflectivity(
      folder.write("n.npy", npy("<f4", 2, 2, std::vector<float>{0, 1, -1, 2})), grid);
  CHECK(is_refused(negative, "n.npy: the factor in row 1, column 0 is -1"));
}

// Protects variety: two seabeds of one description are not one, a file read twice is.
TEST_CASE("terrain of the world is drawn by seed, sequence and name") {
  const TemporaryFolder folder;
  HeightfieldSpec made;
  made.size_m = {4, 3};
  made.cell_m = 0.25;
  made.roughness = RoughnessSpec{0.1, 3, 2};
  made.ripples = {{0.02, 1, 30}};
  HeightfieldSpec read;
  read.file = folder.write("h.npy", npy("<f8", 2, 2, std::vector<double>{0, 1, 2, 3}));
  read.cell_m = 1;
  HeightfieldSpec painted = read;
  painted.reflectivity_map = read.file;
  HeightfieldSpec patched = read;
  patched.patches = {{0.5, 2, 8, 10, 1}};
  Scenario scenario = scenario_of_shapes({made, made, read, read, painted, patched, patched});
  const auto mesh = [](const Result<World>& world, int i) {
    return std::get<MeshShape>(world->objects[i].shape).mesh;
  };
  const auto world = build_world(scenario, 3);
  REQUIRE(world.ok());
  CHECK(mesh(world, 0)->vertices.size() == 17 * 13);
  CHECK(mesh(world, 0)->vertices != mesh(world, 1)->vertices);
  CHECK(mesh(world, 2) == mesh(world, 3));
  CHECK(mesh(world, 2) != mesh(world, 4));
  CHECK(mesh(world, 4)->reflectivity.size() == 4);
  CHECK_FALSE(world->instances[3].vertex_reflectivity);
  CHECK(world->instances[4].vertex_reflectivity);
  CHECK(world->instances[5].vertex_reflectivity);
  CHECK(mesh(world, 5)->vertices == mesh(world, 2)->vertices);
  CHECK(mesh(world, 5)->reflectivity != mesh(world, 6)->reflectivity);
  const auto again = build_world(scenario, 3), other = build_world(scenario, 4);
  CHECK(mesh(again, 0)->vertices == mesh(world, 0)->vertices);
  CHECK(mesh(again, 5)->reflectivity == mesh(world, 5)->reflectivity);
  CHECK(mesh(other, 5)->reflectivity != mesh(world, 5)->reflectivity);
  CHECK(mesh(other, 0)->vertices != mesh(world, 0)->vertices);
  scenario.seed = 6;
  const auto reseeded = build_world(scenario, 3);
  CHECK(mesh(reseeded, 0)->vertices != mesh(world, 0)->vertices);
}

// Protects messages that need the cell of a file: .asc brings its own.
TEST_CASE("stones and patches too small for the cells of a file are refused") {
  const TemporaryFolder folder;
  HeightfieldSpec field;
  field.file = folder.write("h.asc", "ncols 2\nnrows 2\ncellsize 0.5\n0 0 0 0\n");
  field.stones = {{0.8, {0.9, 2}}};
  std::string key;
  const auto stones = make_terrain(field, 1, key);
  REQUIRE_FALSE(stones.ok());
  CHECK(key == "stones.0.diameter_m");
  CHECK(stones.error().message.find("less than 2 cells of 0.5 m") != std::string::npos);
  field.stones[0].diameter_m = {1, 2};
  CHECK(make_terrain(field, 1, key).ok());
  field.stones[0].density_per_m2 = 1;  // times a mean outline of 1.08 m^2
  REQUIRE_FALSE(make_terrain(field, 1, key).ok());
  CHECK(key == "stones.0.density_per_m2");
  field.stones.clear();
  field.patches = {{0.5, 0.9, 0.2, 3, 1}};
  REQUIRE_FALSE(make_terrain(field, 1, key).ok());
  CHECK(key == "patches.0.correlation_m");
}

TEST_CASE("faults of terrain files stand behind their keys") {
  const TemporaryFolder folder;
  HeightfieldSpec broken;
  broken.file = folder.write("h.asc", "ncols 2\n");
  HeightfieldSpec unpainted;
  unpainted.size_m = {4, 3};
  unpainted.cell_m = 1;
  unpainted.reflectivity_map = folder.write("m.png", "no picture");
  const auto world = build_world(scenario_of_shapes({broken, unpainted}));
  CHECK(is_refused(world, "\nobjects.1.shape.heightfield.reflectivity_map: ", ErrorKind::usage));
  CHECK(world.error().message.starts_with("objects.0.shape.heightfield.file: "));
}
