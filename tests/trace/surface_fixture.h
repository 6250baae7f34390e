// Scatterers on the surfaces of a small world.
#pragma once

#include <vector>

#include "core/random.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "trace/scene.h"
#include "trace/surface_points.h"

namespace ensonify::test {

inline Sonar narrow_sonar(double range_max_m) {
  return fan_sonar(90, radians(90), range_max_m, 20);
}

// Width of the Gaussian pulse at -3 dB, V3.
inline constexpr double kResolution_m = 0.033;

inline World world_of(std::vector<WorldObject> objects) {
  World world;
  for (WorldObject& object : objects) {
    object.instance = static_cast<std::uint32_t>(world.objects.size() + 1);
    Instance instance;
    instance.id = static_cast<std::uint16_t>(object.instance);
    instance.name = "object " + std::to_string(object.instance);
    world.instances.push_back(instance);
    world.objects.push_back(std::move(object));
  }
  return world;
}

inline Material diffuse(double reflectivity = 1e-3) {
  Material material;
  material.reflectivity = reflectivity;
  return material;
}

// Pings of a sonar among objects at rest.
struct SurfaceScene {
  World world;
  Sonar sonar;
  std::vector<Pose> poses;
  Water water{1500, 0};
  Tracer tracer{world};
  SurfaceScattering scattering = make_surface_scattering(sonar, water, world);
  std::vector<Pose> objects = own_poses(world);
  SurfaceTiles tiles = tiles_of(*this, 2);

  static SurfaceTiles tiles_of(const SurfaceScene& scene, int threads) {
    const auto seen_by = [&](std::size_t object) {
      std::vector<Pose> all;
      for (const Pose& pose : scene.poses) all.push_back(pose_in(scene.objects[object], pose));
      return all;
    };
    return surface_tiles(scene.world, {{scene.sonar, kResolution_m, seen_by}}, Workers(threads));
  }
  ScattererList at(const Pose& pose, std::uint64_t key = 1, int threads = 2) const {
    return surface_point_list(tiles, tracer, objects, pose, scattering, key, Workers(threads));
  }
};

}  // namespace ensonify::test
