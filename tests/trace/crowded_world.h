// A world of everything that can be met, for tests of the tracer.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/random.h"
#include "core/units.h"
#include "trace/plain_world.h"
#include "trace/tracer.h"
#include "world/world.h"

namespace ensonify {

inline double draw(std::uint64_t i, unsigned k, double low, double high) {
  return low + (high - low) * uniform(77, 0, i, k);
}

inline Pose random_pose(std::uint64_t i, Vec3 at) {
  return {at + Vec3{draw(i, 0, 2, 14), draw(i, 1, -8, 8), draw(i, 2, -3, 3)},
          from_roll_pitch_yaw(draw(i, 3, -3, 3), draw(i, 4, -1, 1), draw(i, 5, -3, 3))};
}

// A rough square of 12 m with 2 x 24 x 24 triangles; smooth normals and reflectivity on request.
inline Shape rough_mesh(bool smooth) {
  constexpr int kCells = 24;
  auto mesh = std::make_shared<Mesh>();
  for (std::uint32_t i = 0; i < (kCells + 1) * (kCells + 1); ++i) {
    const double x = 0.5 * (i / (kCells + 1)) - 6, y = 0.5 * (i % (kCells + 1)) - 6;
    const double z = draw(i, 6, -0.2, 0.2);
    mesh->vertices.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    if (!smooth) continue;
    // One in seven has none.
    mesh->normals.push_back({0, static_cast<float>(z), i % 7 == 0 ? 0.0f : 1.0f});
    mesh->reflectivity.push_back(static_cast<float>(draw(i, 7, 0, 1)));
  }
  for (std::uint32_t i = 0; i < kCells * kCells; ++i) {
    const std::uint32_t a = i / kCells * (kCells + 1) + i % kCells, b = a + kCells + 1;
    mesh->triangles.push_back({a, b, b + 1});
    mesh->triangles.push_back({a, b + 1, a + 1});
  }
  return MeshShape{mesh};
}

// Everything that can be met, at random poses about `at`; the sonar stands inside a room.
inline World crowded_world(Vec3 at) {
  std::vector<std::pair<Shape, Pose>> things{{BoxShape{{18, 16, 9}, true}, {at, {}}},
                                             {PlaneShape{}, {at + Vec3{0, 0, -5}, {}}},
                                             {PlaneShape{}, random_pose(99, at)},
                                             {rough_mesh(false), {at + Vec3{7, 0, -4}, {}}},
                                             {SphereShape{15, true}, {at + Vec3{3, 0, 0}, {}}}};
  for (std::uint64_t i = 0; i < 4; ++i) {
    const auto pose = [&](std::uint64_t k) { return random_pose(10 * i + k, at); };
    things.push_back({rough_mesh(i % 2 == 0), pose(0)});
    things.push_back({BoxShape{{0.3, 0.6, 0.9}, false}, pose(1)});
    things.push_back({CylinderShape{0.4, 0.8}, pose(2)});
    things.push_back({SphereShape{0.7, false}, pose(3)});
  }
  return world_of(std::move(things));
}

inline Fan fan_of(int beams, int rays_azimuth, int rays_elevation) {
  Sonar sonar;
  sonar.beam_count = beams;
  sonar.beam_spacing_rad = radians(120) / beams;
  sonar.elevation_fan_rad = radians(40);
  sonar.rays_azimuth = rays_azimuth;
  sonar.rays_elevation = rays_elevation;
  return make_fan(sonar);
}

inline bool same_hit(const Hit& a, const Hit& b) {
  return a.range_m == b.range_m && a.cos_incidence == b.cos_incidence && a.instance == b.instance &&
         a.reflectivity == b.reflectivity && a.normal == b.normal;
}

}  // namespace ensonify
