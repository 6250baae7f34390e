// What the surfaces of a world do to sound of one sonar, fixed for a sequence.
//
//   SurfaceScattering  make_surface_scattering
//   material_at  wall_at   of the surface at a hit
#pragma once

#include <cstdint>
#include <vector>

#include "acoustics/plate.h"
#include "core/sonar.h"
#include "trace/edges.h"
#include "trace/hits.h"
#include "world/world.h"

namespace ensonify {

struct SurfaceScattering {
  Sonar sonar;
  Water water;
  std::vector<Material> material;  // by instance id; [0] is unused
  // By instance id, then Hit::part - 1; empty where no object has parts.
  std::vector<std::vector<Material>> part_material = {};
  // The response of each distinct wall.
  struct KnownWall {
    Wall wall;
    WallResponse response;
  };
  std::vector<KnownWall> walls = {};
  std::vector<BodyEdges> edges = {};  // of the objects whose edges diffract
};

// `part` as Hit::part.
inline const Material& material_at(const SurfaceScattering& scattering, std::uint32_t instance,
                                   std::uint16_t part) {
  return part == 0 ? scattering.material[instance] : scattering.part_material[instance][part - 1];
}
inline const Material& material_at(const SurfaceScattering& scattering, const Hit& hit) {
  return material_at(scattering, hit.instance, hit.part);
}

// Null if the material is no wall.
const WallResponse* wall_at(const SurfaceScattering& scattering, const Hit& hit);

SurfaceScattering make_surface_scattering(const Sonar& sonar, const Water& water,
                                          const World& world);

}  // namespace ensonify
