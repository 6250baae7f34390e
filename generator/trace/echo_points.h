// The points of surfaces from which the echoes of a list come.
//
//   surface_normals                     of the surfaces there
//   Viewpoint  PointSight  see_points   whether another ping sees points
//   PointMover  point_motions           where the points of scatterers lie in another ping
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/image_planes.h"
#include "core/scatterers.h"
#include "trace/tracer.h"

namespace ensonify {

// For each of the direct scatterers list.items[which[i]]: the normal of its surface there, of unit
// length, in the sonar's frame at transmission, on the side of the sonar; interpolated on smooth
// meshes, as Hit::normal. NaN for point targets and fish, and if no ray finds the surface again.
// `tracer` holds the objects at their poses at transmission.
void surface_normals(const Tracer& tracer, const Pose& sonar_in_world, const ScattererList& list,
                     std::span<const std::uint32_t> which, std::span<Vec3> normals);

// A sonar at one moment; `tracer` holds the objects at their poses then.
struct Viewpoint {
  const Tracer& tracer;
  const Sonar& sonar;
  Pose sonar_in_world;
};

struct PointSight {
  PointState state = PointState::none;
  std::uint16_t occluder = 0;
};

// For each point on a surface (world): outside of the fan or of the sonar's ranges, hidden by the
// first surface on the straight line, or seen. A surface within kSeenWithin of the range is the
// point's own. `points_m` that are neighbors should be near each other.
void see_points(const Viewpoint& view, std::span<const Vec3> points_m,
                std::span<PointSight> sights);

inline constexpr double kSeenWithin = 1e-4;

// Objects at both pings, in the order of World::objects.
struct PointMover {
  const World& world;
  Pose sonar_here;
  std::span<const Pose> objects_here, objects_there;
  Viewpoint there;
  double sample_m = 0;  // range step, c / 2b
};

// Of the direct scatterers list.items[which[i]]: points of objects move with them, point targets
// rest. Volumes have no points. The echoes of an elastic body come from its center or axis, which
// its own surface does not hide.
void point_motions(const PointMover& mover, const ScattererList& list,
                   std::span<const std::uint32_t> which, std::span<PointMotion> motions);

}  // namespace ensonify
