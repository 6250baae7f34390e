// Scatterers fixed on the surfaces: those of them that one ping hears.
//
//   SurfacePoints         of the sequence
//   surface_point_list    of a ping
//   leaves_of             where they lie
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/scatter.h"
#include "trace/surface_tiles.h"
#include "trace/tracer.h"

namespace ensonify {

// A scatterer on its surface, whether it is heard or not.
struct SurfaceLeaf {
  std::uint64_t key = 0;
  double area_m2 = 0;
  Vec3 position_m;  // in the frame of the object
  Vec3 normal;      // likewise
};

// The leaves of a tile, in the order of their paths. `speckle_key` is the sequence's
// (RandomKeys::speckle): it says where in its leaf each scatterer lies, draw 1 of ping 0.
void leaves_of(const SurfaceTile& tile, std::uint64_t speckle_key,
               const std::function<void(const SurfaceLeaf&)>& visit);

// One scatterer for each leaf whose own surface is the first that the ray to it meets:
// sigma^2 = factor s_b(alpha) A cos(alpha_face)/cos(alpha), A the leaf's area, the factor,
// cos(alpha) and the material those of the hit, as of rays; alpha_face differs from alpha only
// where a mesh has smooth normals. Objects where `object_in_world` says; `tracer` must be of the
// same moment. The same for any workers.
ScattererList surface_point_list(const SurfaceTiles& tiles, const Tracer& tracer,
                                 std::span<const Pose> object_in_world, const Pose& sonar_in_world,
                                 const SurfaceScattering& scattering, std::uint64_t speckle_key,
                                 const Workers& workers);

}  // namespace ensonify
