// Scatterers fixed on the surfaces: how finely the surfaces of a sequence are cut into leaves, each
// of which holds one scatterer, and those of them that one ping hears.
//
// The leaves are settled once for all pings: so a scatterer is the same whatever ping hears it.
//
//   SurfaceTile  SurfaceTiles  surface_tiles
//   SurfaceViews        from where the surfaces are seen
//   nearest_in_fan      whether a ball is heard, and from how near
//   leaf_area_m2        wanted at a range
//   SurfaceLeaf  leaves_of   where the scatterers lie
//   SurfacePoints       of the sequence
//   surface_point_list  of a ping
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "trace/scatter.h"
#include "trace/tracer.h"
#include "world/shapes.h"
#include "world/world.h"

namespace ensonify {

// Scatterers in the smallest -3 dB cell of beam and pulse, at least; more where
// sonar.rays_per_cell is.
inline constexpr double kScatterersPerCell = 20;

// More leaves than this in one ping are refused.
inline constexpr std::uint64_t kMostLeaves = std::uint64_t{1} << 27;

// A piece of a surface that is small beside its distance, with 2^levels leaves of equal area.
struct SurfaceTile {
  Patch patch;  // in the frame of the object
  Ball ball;    // around it
  std::uint32_t object = 0;
  std::uint32_t levels = 0;
  std::uint64_t root = 0;  // key of the object's primitive that the tile is a part of
  std::uint64_t path = 1;  // the halves taken from there: after a leading 1, a bit each
};

// The identity of the scatterer in the leaf at `path` from the primitive `root`.
std::uint64_t leaf_key(std::uint64_t root, std::uint64_t path);

struct SurfaceTiles {
  std::vector<SurfaceTile> tiles;
  std::vector<std::uint32_t> instance;  // by object
  std::uint64_t most_leaves = 0;  // in the fan of one ping, more or less: the most of all pings
};

// The sonar's pose in the frame of an object.
Pose pose_in(const Pose& object_in_world, const Pose& sonar_in_world);

struct SurfaceViews {
  Sonar sonar;
  double resolution_m = 0;  // -3 dB width of the pulse, in range
  // The sonar's pose in the frame of that one of World::objects, at all pings of the sequence.
  std::function<std::vector<Pose>(std::size_t object)> sonar_in_object;
};

// The area of the smallest cell, range . beam width . range resolution, by kScatterersPerCell; of
// the beam's footprint where that is less high than the pulse is long.
double leaf_area_m2(const SurfaceViews& views, double range_m);

// The least range at which any of a ball, given in the sonar's frame, may be heard; none where it
// lies outside the fan and its ranges.
std::optional<double> nearest_in_fan(const Sonar& sonar, const Ball& ball);

// All that any ping may hear, each tile as fine as the nearest of them wants. Keys follow from an
// object's name, its primitive and the path alone. The same for any workers.
SurfaceTiles surface_tiles(const World& world, const SurfaceViews& views, const Workers& workers);

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
