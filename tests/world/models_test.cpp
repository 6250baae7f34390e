#include "world/everyday_objects/everyday_objects.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <random>

#include "catch.h"
#include "core/units.h"
#include "scenario/scenario.h"
#include "scenes.h"
#include "world/world.h"

using namespace ensonify;

namespace {

Vec3 corner(const Mesh& mesh, std::uint32_t v) {
  return {mesh.vertices[v][0], mesh.vertices[v][1], mesh.vertices[v][2]};
}

double six_volumes(const Mesh& mesh, const std::array<std::uint32_t, 3>& t) {
  return dot(corner(mesh, t[0]), cross(corner(mesh, t[1]), corner(mesh, t[2])));
}

double volume(const Mesh& mesh) {
  double six = 0;
  for (const auto& t : mesh.triangles) six += six_volumes(mesh, t);
  return six / 6;
}

Vec3 centre_of_mass(const Mesh& mesh) {
  Vec3 sum;
  for (const auto& t : mesh.triangles) {
    const Vec3 corners = corner(mesh, t[0]) + corner(mesh, t[1]) + corner(mesh, t[2]);
    sum = sum + (six_volumes(mesh, t) / 24) * corners;
  }
  return (1 / volume(mesh)) * sum;
}

struct Part {
  int vertices = 0, triangles = 0;
  double volume = 0;
};

// What hangs together by shared vertices.
std::vector<Part> parts(const Mesh& mesh) {
  std::vector<std::uint32_t> leader(mesh.vertices.size());
  std::iota(leader.begin(), leader.end(), 0u);
  const std::function<std::uint32_t(std::uint32_t)> find = [&](std::uint32_t v) {
    while (leader[v] != v) v = leader[v] = leader[leader[v]];
    return v;
  };
  for (const auto& t : mesh.triangles) {
    leader[find(t[1])] = find(t[0]);
    leader[find(t[2])] = find(t[0]);
  }
  std::map<std::uint32_t, Part> found;
  for (std::uint32_t v = 0; v < leader.size(); ++v) ++found[find(v)].vertices;
  for (const auto& t : mesh.triangles) {
    Part& part = found[find(t[0])];
    ++part.triangles;
    part.volume += six_volumes(mesh, t) / 6;
  }
  std::vector<Part> all;
  for (const auto& [v, part] : found) all.push_back(part);
  return all;
}

struct Extent {
  Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
};

Extent extent(const Mesh& mesh) {
  Extent e;
  for (const auto& [x, y, z] : mesh.vertices) {
    e.low = {std::min<double>(e.low.x, x), std::min<double>(e.low.y, y),
             std::min<double>(e.low.z, z)};
    e.high = {std::max<double>(e.high.x, x), std::max<double>(e.high.y, y),
              std::max<double>(e.high.z, z)};
  }
  return e;
}

// Crossings of a ray (Moller and Trumbore), as distance and whether it enters there.
std::vector<std::pair<double, bool>> crossings(const Mesh& mesh, Vec3 origin, Vec3 direction) {
  std::vector<std::pair<double, bool>> found;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = corner(mesh, t[0]), ab = corner(mesh, t[1]) - a, ac = corner(mesh, t[2]) - a;
    const Vec3 p = cross(direction, ac), s = origin - a, q = cross(s, ab);
    const double d = dot(ab, p), u = dot(s, p) / d, v = dot(direction, q) / d;
    if (!(u >= 0 && v >= 0 && u + v <= 1)) continue;
    const double distance = dot(ac, q) / d;
    if (distance > 0) found.emplace_back(distance, dot(direction, cross(ab, ac)) < 0);
  }
  std::sort(found.begin(), found.end());
  return found;
}

constexpr std::array kSizes = {0.05, 0.3, 2.0, 40.0};

void for_each_model(const std::function<void(ModelKind, double, const Mesh&)>& check) {
  for (const auto& [word, kind] : kModelKinds) {
    CHECK(word_of(kind) == word);
    for (const double size : kSizes) {
      INFO(word << " of " << size);
      check(kind, size, model_mesh(kind, size));
    }
  }
}

}  // namespace

// Protects masks, shadows and level sets: no hole, no face turned over, none without area.
TEST_CASE("every part of a model is closed and looks outwards") {
  for_each_model([](ModelKind, double size, const Mesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    double smallest_area = size * size;
    for (const auto& t : mesh.triangles) {
      for (int i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
      const Vec3 a = corner(mesh, t[0]);
      smallest_area = std::min(smallest_area,
                               length(cross(corner(mesh, t[1]) - a, corner(mesh, t[2]) - a)) / 2);
    }
    CHECK(smallest_area > 1e-8 * size * size);
    int open = 0;
    for (const auto& [edge, times] : edges) {
      const auto back = edges.find({edge.second, edge.first});
      if (times != 1 || back == edges.end() || back->second != 1) ++open;
    }
    CHECK(open == 0);
    for (const Part& part : parts(mesh)) CHECK(part.volume > 0);
    CHECK(mesh.triangles.size() <= 5000);
  });
}

// Protects the shapes themselves: V - E + F is 2 for a ball and 0 for a ring, and a closed part has
// three edges to two faces.
TEST_CASE("models are made of as many balls and rings as they should") {
  const std::map<ModelKind, std::pair<int, int>> balls_and_rings = {
      {ModelKind::bottle, {1, 0}}, {ModelKind::can, {1, 0}},    {ModelKind::tyre, {0, 1}},
      {ModelKind::chain, {0, 11}}, {ModelKind::hook, {1, 1}},   {ModelKind::propeller, {5, 0}},
      {ModelKind::valve, {6, 1}},  {ModelKind::carton, {1, 0}}, {ModelKind::shackle, {4, 0}},
      {ModelKind::wall, {1, 0}},   {ModelKind::pipe, {0, 1}},   {ModelKind::crab_pot, {108, 2}},
      {ModelKind::ladder, {9, 0}}, {ModelKind::net, {36, 0}},
  };
  for_each_model([&](ModelKind kind, double, const Mesh& mesh) {
    std::pair<int, int> found;
    for (const Part& part : parts(mesh)) {
      const int euler = part.vertices - part.triangles * 3 / 2 + part.triangles;
      CHECK((euler == 0 || euler == 2));
      ++(euler == 2 ? found.first : found.second);
    }
    CHECK(found == balls_and_rings.at(kind));
  });
}

// Protects placement: z = 0 is the bottom, the pose names the middle, the size is the longest edge.
TEST_CASE("models have the size asked for and lie on z = 0 above their origin") {
  for_each_model([](ModelKind, double size, const Mesh& mesh) {
    const auto [low, high] = extent(mesh);
    const Vec3 edges = high - low;
    CHECK(std::max({edges.x, edges.y, edges.z}) == Approx(size).epsilon(1e-6));
    CHECK(std::min({edges.x, edges.y, edges.z}) > 0.03 * size);
    CHECK(low.z == 0);
    CHECK(low.x + high.x == Approx(0).margin(1e-6 * size));
    CHECK(low.y + high.y == Approx(0).margin(1e-6 * size));
  });
}

// Protects the naturalness of scenes: the centre of mass is above what touches the bottom (to 2% of
// the size), whichever way one looks, so that nothing would topple.
TEST_CASE("models are at rest") {
  for_each_model([](ModelKind, double size, const Mesh& mesh) {
    const Vec3 mass = centre_of_mass(mesh);
    for (int i = 0; i < 64; ++i) {
      const double angle = 2 * kPi * i / 64;
      const Vec3 way{std::cos(angle), std::sin(angle), 0};
      double reach = -size;
      for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
        const Vec3 p = corner(mesh, v);
        if (p.z < 0.02 * size) reach = std::max(reach, dot(p, way));
      }
      INFO("towards " << angle);
      CHECK(reach > dot(mass, way));
    }
  });
}

// Protects the tracer's normals: whatever is met first from outside is met from its front, and what
// goes in comes out. 300 rays a model, fixed seed.
TEST_CASE("rays from outside meet models from outside", "[figure]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const auto& [word, kind] : kModelKinds) {
    INFO(word);
    const Mesh mesh = model_mesh(kind, 0.3);
    const auto [low, high] = extent(mesh);
    int met = 0, from_behind = 0, unbalanced = 0;
    for (int i = 0; i < 300; ++i) {
      const auto draw = [&] { return Vec3{uniform(random), uniform(random), uniform(random)}; };
      const Vec3 origin = normalized(draw());
      const Vec3 part = 0.5 * (draw() + Vec3{1, 1, 1});
      const Vec3 size = high - low;
      const Vec3 aim = low + Vec3{part.x * size.x, part.y * size.y, part.z * size.z};
      const auto found = crossings(mesh, origin, normalized(aim - origin));
      if (found.empty()) continue;
      ++met;
      if (!found.front().second) ++from_behind;
      int depth = 0;
      for (const auto& [distance, enters] : found) depth += enters ? 1 : -1;
      if (depth != 0) ++unbalanced;
    }
    CHECK(met > 20);
    CHECK(from_behind == 0);
    CHECK(unbalanced == 0);
  }
}

// Protects what the documentation states of them: bounding boxes of real objects, edges by size, to
// 2 %.
TEST_CASE("models have the proportions of what they stand for") {
  const struct {
    ModelKind kind;
    std::array<double, 3> edges;
  } cases[] = {{ModelKind::bottle, {229, 61, 61}},  {ModelKind::can, {115, 66, 66}},
               {ModelKind::tyre, {634, 634, 195}},  {ModelKind::carton, {195, 90, 60}},
               {ModelKind::wall, {1000, 600, 240}}, {ModelKind::crab_pot, {24, 24, 18}}};
  for (const auto& [kind, edges] : cases) {
    INFO(word_of(kind));
    const auto [low, high] = extent(model_mesh(kind, edges[0]));
    std::array<double, 3> found{high.x - low.x, high.y - low.y, high.z - low.z};
    std::sort(found.rbegin(), found.rend());
    for (int i = 0; i < 3; ++i) CHECK(found[i] == Approx(edges[i]).epsilon(0.02));
  }
}

// Protects memory: a heap of a thousand cans is one mesh.
TEST_CASE("models of one kind and size share a mesh") {
  const ModelSpec can{ModelKind::can, 0.1}, larger{ModelKind::can, 0.2}, wall{ModelKind::wall, 0.1};
  const World world = test::built(test::scenario_of_shapes({can, can, larger, wall}));
  CHECK(test::mesh_of(world, 0) == test::mesh_of(world, 1));
  CHECK(test::mesh_of(world, 0) != test::mesh_of(world, 2));
  CHECK(test::mesh_of(world, 0) != test::mesh_of(world, 3));
  CHECK(extent(*test::mesh_of(world, 2)).high.x == Approx(0.1));
}
