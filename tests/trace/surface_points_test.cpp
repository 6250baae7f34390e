// Scatterers fixed on surfaces: how many, where, and who hears them.
#include "trace/surface_points.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "catch.h"
#include "surface_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

SurfaceScene room(std::vector<Pose> poses, std::vector<WorldObject> more = {}) {
  std::vector<WorldObject> objects{{1, BoxShape{{5.5, 5.5, 2}, true}, {}, diffuse()}};
  objects.insert(objects.end(), more.begin(), more.end());
  return {world_of(objects), narrow_sonar(10), std::move(poses)};
}

std::map<std::uint64_t, Vec3> in_world(const ScattererList& list, const Pose& pose) {
  std::map<std::uint64_t, Vec3> places;
  for (const Scatterer& s : list.items) places[s.key] = transform_point(pose, s.position_m);
  return places;
}

bool same(const ScattererList& a, const ScattererList& b) {
  return std::ranges::equal(a.items, b.items, [](const Scatterer& x, const Scatterer& y) {
    return x.key == y.key && x.position_m == y.position_m && x.gain == y.gain &&
           x.standard_deviation == y.standard_deviation && x.beam == y.beam;
  });
}

std::vector<SurfaceLeaf> all_leaves(const SurfaceTiles& tiles, std::uint64_t key = 1) {
  std::vector<SurfaceLeaf> leaves;
  for (const SurfaceTile& tile : tiles.tiles) {
    leaves_of(tile, key, [&](const SurfaceLeaf& leaf) { leaves.push_back(leaf); });
  }
  return leaves;
}

// Sees all around, up and down; a wide beam, so that a few scatterers are enough.
Sonar open_sonar(double range_max_m) {
  Sonar sonar = narrow_sonar(range_max_m);
  sonar.beam_count = 360;
  sonar.elevation_fan_rad = kPi;
  sonar.beam_width_rad = radians(6);
  return sonar;
}

std::shared_ptr<const Mesh> tetrahedron() {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{-1, -1, -1}, {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}};
  mesh->triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  return mesh;
}

}  // namespace

// Protects the level of every surface: each part of it has exactly one scatterer for it.
TEST_CASE("leaves add up to the surface of every shape") {
  const Pose eye{{-4, 0.3, 0.2}, {}};
  const auto sum = [&](Shape shape) {
    const SurfaceScene scene{world_of({{1, shape, {}, diffuse()}}), open_sonar(20), {eye}};
    double area = 0;
    for (const SurfaceLeaf& leaf : all_leaves(scene.tiles)) area += leaf.area_m2;
    return area;
  };
  CHECK(sum(BoxShape{{1, 0.5, 2}, false}) == Approx(8 * (0.5 + 2 + 1)).epsilon(1e-9));
  CHECK(sum(SphereShape{1, false}) == Approx(4 * kPi).epsilon(1e-9));
  CHECK(sum(CylinderShape{0.5, 1}) == Approx(2 * kPi + kPi / 2).epsilon(1e-9));
  CHECK(sum(MeshShape{tetrahedron()}) == Approx(8 * std::sqrt(3.0)).epsilon(1e-9));
}

// Protects identities: no two scatterers of a world share a draw, none has a point's or a mirror's.
TEST_CASE("keys are unique and leave the reserved bits alone", "[figure]") {
  const SurfaceScene scene = room({{}}, {{2, SphereShape{0.3, false}, {{3, 0, 0}, {}}, diffuse()},
                                         {3, PlaneShape{}, {{0, 0, -1}, {}}, diffuse()}});
  std::vector<std::uint64_t> keys;
  for (const SurfaceLeaf& leaf : all_leaves(scene.tiles)) keys.push_back(leaf.key);
  CHECK(keys.size() > 100'000);
  std::ranges::sort(keys);
  CHECK(std::ranges::adjacent_find(keys) == keys.end());
  CHECK(keys.back() >> 62 == 0);
}

// Protects speckle statistics: 20 in the smallest -3 dB cell, at every range and from every ping.
TEST_CASE("a cell of beam and pulse holds twenty scatterers") {
  const std::vector<Pose> poses{{}, {{3, 1, 0}, {}}, {{-2, 0, 0.5}, from_roll_pitch_yaw(0, 0, 1)}};
  const SurfaceScene scene = room(poses);
  for (const SurfaceTile& tile : scene.tiles.tiles) {
    const double leaf = std::ldexp(std::visit([](const auto& p) { return area_m2(p); }, tile.patch),
                                   -int(tile.levels));
    for (const Pose& pose : poses) {
      const Ball ball{inverse_transform_point(pose, tile.ball.centre_m), tile.ball.radius_m};
      const auto nearest = nearest_in_fan(scene.sonar, ball);
      if (!nearest) continue;
      REQUIRE(leaf <= *nearest * radians(1) * kResolution_m / 20 * (1 + 1e-9));
    }
  }
  // And not many more than that: the wall ahead, of 0.0055 m2 a cell at 5.5 m with 20 to 80.
  const double wall = 5.5 * radians(1) * kResolution_m;
  const SurfaceScene one = room({{}});
  int count = 0;
  for (const SurfaceLeaf& leaf : all_leaves(one.tiles)) {
    count += leaf.position_m.x == 5.5 && std::abs(leaf.position_m.y) < 0.5 &&
             std::abs(leaf.position_m.z) < 0.5;
  }
  CHECK(count * wall > 20);
  CHECK(count * wall < 80);
}

// Protects the evenness of the surface: counts in windows of 100 leaves vary far less than by
// chance, which would be 100.
TEST_CASE("scatterers are stratified") {
  const SurfaceScene scene{
      world_of({{1, BoxShape{{5.5, 5.5, 2}, true}, {}, diffuse()}}), narrow_sonar(10), {{}}};
  std::vector<Vec3> places;
  double area = 0;
  for (const SurfaceLeaf& leaf : all_leaves(scene.tiles)) {
    const Vec3 p = leaf.position_m;
    if (p.x != 5.5 || std::abs(p.y) > 0.9 || std::abs(p.z) > 0.9) continue;
    places.push_back(p);
    area = leaf.area_m2;
  }
  const double side = std::sqrt(100 * area);
  double squares = 0;
  constexpr int kWindows = 200;
  for (int i = 0; i < kWindows; ++i) {
    const Philox4 w = random_words(5, 0, i, 0);
    const double y = -0.9 + (1.8 - side) * uniform_from_word(w.v[0]);
    const double z = -0.9 + (1.8 - side) * uniform_from_word(w.v[1]);
    const auto count = std::ranges::count_if(
        places, [&](Vec3 p) { return p.y >= y && p.y < y + side && p.z >= z && p.z < z + side; });
    squares += (count - 100.0) * (count - 100.0) / kWindows;
  }
  CHECK(squares > 1);
  CHECK(squares < 30);
}

// Protects reproducibility: neither threads nor the order of pings change a scatterer.
TEST_CASE("the same scatterers with any number of threads") {
  SurfaceScene scene =
      room({{}, {{1, 0, 0}, {}}}, {{2, CylinderShape{0.2, 1}, {{4, 0, 0}, {}}, diffuse()}});
  const ScattererList one = scene.at({}, 1, 1);
  CHECK(one.size() > 10'000);
  CHECK(same(one, scene.at({}, 1, 3)));
  scene.tiles = SurfaceScene::tiles_of(scene, 1);
  CHECK(same(one, scene.at({}, 1, 1)));
}

// Protects the point of it all: a scatterer heard from two poses is one scatterer.
TEST_CASE("scatterers stay where they are while the sonar moves", "[figure]") {
  const Pose a{}, b{{0.4, -0.2, 0.1}, from_roll_pitch_yaw(0.05, 0.1, 0.2)};
  const SurfaceScene scene = room({a, b});
  const auto from_a = in_world(scene.at(a), a), from_b = in_world(scene.at(b), b);
  int both = 0;
  double farthest = 0;
  for (const auto& [key, place] : from_a) {
    const auto other = from_b.find(key);
    if (other == from_b.end()) continue;
    ++both;
    farthest = std::max(farthest, length(other->second - place));
  }
  CHECK(farthest < 1e-9);
  CHECK(both > 0.3 * double(from_a.size()));
  // Another sequence or seed has others in the same leaves.
  const auto other = in_world(scene.at(a, 2), a);
  const auto& [key, place] = *from_a.begin();
  if (other.contains(key)) CHECK(length(other.at(key) - place) > 0);
}

// Protects scenes against one another: an object more only hides what is behind it.
TEST_CASE("another object leaves a surface's scatterers alone") {
  const WorldObject ball{2, SphereShape{0.3, false}, {{3, 0, 0}, {}}, diffuse()};
  const auto alone = in_world(room({{}}).at({}), {});
  const SurfaceScene scene = room({{}}, {ball});
  std::size_t walls = 0, heard_alone = 0;
  for (const Scatterer& s : scene.at({}).items) {
    if (s.instance != 1) continue;
    ++walls;
    const auto found = alone.find(s.key);
    if (found != alone.end()) heard_alone += found->second == s.position_m;
  }
  CHECK(walls == heard_alone);
  CHECK(walls < alone.size());
  // Exactly what the ball covers is gone.
  std::size_t covered = 0;
  for (const auto& [key, place] : alone) {
    const double along = dot(normalized(place), Vec3{3, 0, 0});
    covered += along > 0 && 9 - along * along < 0.09;
  }
  CHECK(alone.size() - walls == covered);
}

// Protects moving objects: the scatterers are at the same places of the object, wherever that is.
TEST_CASE("a moved object carries its scatterers along") {
  const Pose first{{3, 0, 0}, {}}, second{{4, 1, 0.2}, from_roll_pitch_yaw(0.3, 0.2, 0.6)};
  SurfaceScene scene{
      world_of({{1, BoxShape{{0.4, 0.3, 0.2}, false}, first, diffuse()}}), narrow_sonar(10), {{}}};
  const auto seen_by = [&](std::size_t) {
    return std::vector<Pose>{pose_in(first, {}), pose_in(second, {})};
  };
  scene.tiles = surface_tiles(scene.world, {{scene.sonar, kResolution_m, seen_by}}, Workers(1));
  const auto in_object = [&](const Pose& pose) {
    std::map<std::uint64_t, Vec3> places;
    const Tracer tracer = scene.tracer.at({{pose}});
    for (const Scatterer& s :
         surface_point_list(scene.tiles, tracer, {{pose}}, {}, scene.scattering, 1, Workers(1))
             .items) {
      places[s.key] = inverse_transform_point(pose, s.position_m);
    }
    return places;
  };
  const auto a = in_object(first), b = in_object(second);
  int both = 0;
  for (const auto& [key, place] : a) {
    if (!b.contains(key)) continue;
    ++both;
    REQUIRE(length(b.at(key) - place) < 1e-9);
  }
  CHECK(both > 100);
}

// Protects what is heard: of closed bodies the side that faces the sonar, all of it at any grazing
// angle, seen from within as from outside.
TEST_CASE("what faces the sonar is heard and nothing else", "[figure]") {
  const auto check = [](Shape shape, Pose pose, auto faces) {
    Sonar sonar = open_sonar(30);
    sonar.beam_width_rad = radians(12);
    const SurfaceScene scene{world_of({{1, shape, pose, diffuse()}}), sonar, {{}}};
    std::size_t expected = 0;
    for (const SurfaceLeaf& leaf : all_leaves(scene.tiles)) {
      const Vec3 p = transform_point(pose, leaf.position_m);
      // Outwards: all bodies here are convex, about their origin.
      const double sign = dot(leaf.position_m, leaf.normal) < 0 ? -1 : 1;
      const double towards = sign * dot(p, rotate(pose.rotation, leaf.normal));
      const double range = length(p);
      expected += range <= 30 && faces(towards);
    }
    const auto heard = static_cast<double>(scene.at({}).size());
    CHECK(heard == Approx(double(expected)).epsilon(1e-4));
    CHECK(heard > 1000);
  };
  const Pose turned{{6, 1, -0.5}, from_roll_pitch_yaw(0.4, 0.2, 1)};
  const auto outside = [](double towards) { return towards < 0; };
  const auto within = [](double towards) { return towards > 0; };
  check(SphereShape{1, false}, turned, outside);
  check(CylinderShape{0.5, 1}, turned, outside);
  check(SphereShape{4, true}, {{1, 1, 0}, {}}, within);
  check(CylinderShape{4, 4}, {{1, 1, 0}, {}}, within);
  // At 1 degree of grazing at 20 m.
  check(PlaneShape{}, {{0, 0, -0.4}, {}}, [](double) { return true; });
}

// Protects meshes: face normals of triangles that wind outwards.
TEST_CASE("a mesh is heard on its side") {
  const SurfaceScene scene{
      world_of({{1, MeshShape{tetrahedron()}, {{-5, 0, 0}, {}}, diffuse()}}), open_sonar(30), {{}}};
  std::size_t facing = 0;
  for (const SurfaceLeaf& leaf : all_leaves(scene.tiles)) {
    const Vec3 p = leaf.position_m + Vec3{-5, 0, 0};
    facing += dot(p, leaf.normal) * dot(leaf.position_m, leaf.normal) < 0;
  }
  CHECK(double(scene.at({}).size()) == Approx(double(facing)).epsilon(1e-3));
  CHECK(facing > 300);
}

// Protects the law: sigma^2 is the backscatter strength at the angle, times the leaf.
TEST_CASE("moments are those of the leaf", "[figure]") {
  SurfaceScene scene{
      world_of({{1, BoxShape{{2.5, 2.5, 1}, true}, {}, diffuse()}}), narrow_sonar(5), {{}}};
  scene.scattering.material[1].law = Lambert{2};
  scene.scattering.material[1].coherent = CoherentModel::rician;
  scene.scattering.material[1].rician_k = 3;
  std::map<std::uint64_t, SurfaceLeaf> leaves;
  for (const SurfaceLeaf& leaf : all_leaves(scene.tiles)) leaves[leaf.key] = leaf;
  const auto off = [](double value, double expected) { return std::abs(value / expected - 1); };
  double worst = 0;
  const ScattererList list = scene.at({});
  for (const Scatterer& s : list.items) {
    const SurfaceLeaf& leaf = leaves.at(s.key);
    const double cosine = std::abs(dot(normalized(leaf.position_m), leaf.normal));
    const double squared = 1e-3 * cosine * cosine * cosine * leaf.area_m2;
    worst = std::max({worst, off(s.mean.real(), std::sqrt(0.75 * squared)),
                      off(s.standard_deviation, std::sqrt(0.25 * squared))});
  }
  CHECK(list.size() > 10'000);
  CHECK(worst < 1e-5);
}

// Protects rays.min_per_cell beside scatterers on surfaces: twenty are the least, more may be asked
// for.
TEST_CASE("a cell has as many leaves as are asked for, and no fewer than twenty") {
  Sonar sonar = open_sonar(20);
  const auto area = [&](int per_cell) {
    sonar.rays_per_cell = per_cell;
    return leaf_area_m2({sonar, 0.05, {}}, 10);
  };
  CHECK(area(0) == Approx(10 * sonar.beam_width_rad * 0.05 / 20));
  CHECK(area(5) == area(0));
  CHECK(area(20) == area(0));
  CHECK(area(60) == Approx(area(0) / 3));
}
