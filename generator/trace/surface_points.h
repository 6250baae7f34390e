// Scatterers that are fixed on surfaces. The surfaces of a sequence are cut into leaves with one
// scatterer each, some of which each ping hears.
//
// The leaves are fixed once for all pings and all sonars that hear the world, so that a scatterer
// is the same for all of them. On ground and on the walls of rooms they follow a pattern that needs
// few of them (even_points.h).
//
//   SurfaceTile  SurfaceTiles  surface_tiles
//   SurfaceViews        from where a sonar sees the surfaces
//   nearest_in_fan      whether a ball may be heard, and its least range
//   FanPart  part_in_fan    whether all of it is
//   leaf_area_m2  even_leaf_area_m2     largest area at a range
//   SurfaceLeaf  leaves_of   where the scatterers lie
//   surface_point_list  the scatterers of a ping
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
#include "trace/even_points.h"
#include "trace/scatter.h"
#include "trace/tracer.h"
#include "world/shapes.h"
#include "world/world.h"

namespace ensonify {

// Least number of scatterers in the smallest -3 dB cell of beam and pulse, unless they follow the
// pattern; sonar.rays_per_cell may ask for more.
inline constexpr double kScatterersPerCell = 20;

// Most of them that the expected level of surfaces that follow the pattern asks for.
inline constexpr double kEvenScatterersPerCell = 25;

// More leaves than this in one ping are refused.
inline constexpr std::uint64_t kMostLeaves = std::uint64_t{1} << 27;

// A piece of a surface that is small compared with its distance, with 2^levels leaves of equal
// area, or as many as the pattern has places on it.
struct SurfaceTile {
  Patch patch;  // in the frame of the object
  Ball ball;    // around it
  std::uint32_t object = 0;
  std::uint32_t levels = 0;
  std::uint64_t root = 0;    // key of the primitive that contains the tile
  std::uint64_t path = 1;    // the halves taken from there: a leading 1, then one bit each
  int axis = -1, scale = 0;  // of the pattern (EvenPlane, even_scale); -1: leaves without it
};

// The identity of the scatterer in the leaf at `path` from the primitive `root`.
std::uint64_t leaf_key(std::uint64_t root, std::uint64_t path);

struct SurfaceTiles {
  std::vector<SurfaceTile> tiles;
  std::vector<std::uint32_t> instance;  // by object
  // By sonar: the approximate maximum over all its pings, in the fan of one.
  std::vector<std::uint64_t> most_leaves;
};

// The sonar's pose in the frame of an object.
Pose pose_in(const Pose& object_in_world, const Pose& sonar_in_world);

struct SurfaceViews {
  Sonar sonar;
  double resolution_m = 0;  // -3 dB width of the pulse, in range
  // The sonar's pose in the frame of World::objects[object], at all pings of the sequence.
  std::function<std::vector<Pose>(std::size_t object)> sonar_in_object;
  EvenSpacing even = {};  // without spacings no surface follows the pattern
};

// The area of the smallest cell, range . beam width . range resolution, divided by the scatterers
// per cell. If the height of the beam is smaller than the range resolution, it replaces the range
// resolution.
double leaf_area_m2(const SurfaceViews& views, double range_m);

// The same for surfaces that follow the pattern: the square of the longest spacing, in proportion
// less where the beam is not as high as the range resolution. No smaller than the share
// of kEvenScatterersPerCell in the smallest cell, but as small as sonar.rays_per_cell asks for.
double even_leaf_area_m2(const SurfaceViews& views, double range_m);

// The least range at which any part of a ball, given in the sonar's frame, may be heard; none if
// the ball lies outside the fan or its ranges.
std::optional<double> nearest_in_fan(const Sonar& sonar, const Ball& ball);

// How much of a ball may be heard: certainly nothing, some of it, or nearly all of it, so that
// asking for its parts is not worthwhile.
enum class FanPart { none, some, all };
FanPart part_in_fan(const Sonar& sonar, const Ball& ball);

// All tiles that any ping of any sonar may hear, each as fine as the sonar that needs most of it at
// its nearest ping. Keys depend only on an object's name, its primitive and the path. The result
// does not depend on the workers. Up to kMostViews sonars.
inline constexpr std::size_t kMostViews = 16;
SurfaceTiles surface_tiles(const World& world, const std::vector<SurfaceViews>& views,
                           const Workers& workers);

// A scatterer on its surface, whether it is heard or not.
struct SurfaceLeaf {
  std::uint64_t key = 0;
  double area_m2 = 0;
  Vec3 position_m;  // in the frame of the object
  Vec3 normal;      // likewise
};

// The leaves of a tile, in the order of their paths. `places_key` is the sequence's
// (ping/ping_series.h): its draw 1 of ping 0 places each scatterer in its leaf, and draw 2 places
// the pattern.
void leaves_of(const SurfaceTile& tile, std::uint64_t places_key,
               const std::function<void(const SurfaceLeaf&)>& visit);

// One scatterer for each visible leaf: the ray to it meets the leaf's own surface first.
// sigma^2 = factor s_b(alpha) A cos(alpha_face)/cos(alpha), where A is the leaf's area, and factor,
// cos(alpha) and material are those of the hit, as for rays; alpha_face differs from alpha only on
// meshes with smooth normals. `tracer` must hold the objects at the poses `object_in_world`. The
// result does not depend on the workers.
ScattererList surface_point_list(const SurfaceTiles& tiles, const Tracer& tracer,
                                 std::span<const Pose> object_in_world, const Pose& sonar_in_world,
                                 const SurfaceScattering& scattering, std::uint64_t places_key,
                                 const Workers& workers);

}  // namespace ensonify
