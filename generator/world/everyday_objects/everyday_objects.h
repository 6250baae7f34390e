// Everyday objects as triangle meshes, which detectors are trained to find on the bottom.
//
//   model_mesh     kind and size -> mesh
//   ..._solid      one of each kind, in its own proportions
//   Solid          triangles of which the objects are built
//   loft           surface over a row of rings, the base of the others
//   turned         a profile turned about z
//   tube  torus    a circle led along a plane curve
//   box
//   joined  moved  several as one; elsewhere
//   arc  bezier    points of plane curves
//
// Invariant of all: every part is closed (an edge belongs to two triangles, which run along it in
// opposite directions) and its faces look outwards; parts may reach into each other.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/vec.h"
#include "scenario/model_spec.h"
#include "world/mesh.h"

namespace ensonify {

struct Solid {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // anticlockwise, seen from outside
};

// Six times the volume is a sum of determinants over the faces (divergence theorem); parts that
// reach into each other count twice.
double volume(const Solid& solid);

// capped: two flat lids. looped: the last ring runs into the first.
enum class Ends { capped, looped };

using Ring = std::vector<Vec3>;

// All rings have the same number of points, in either direction: faces are oriented outwards.
Solid loft(const std::vector<Ring>& rings, Ends ends);

struct ProfilePoint {
  double radius = 0, z = 0;  // off the axis: radius > 0
};

// A whole multiple of four corners puts the widest points onto the axes x and y.
Solid turned(const std::vector<ProfilePoint>& profile, int corners, Ends ends = Ends::capped);

struct TubePoint {
  Vec3 position;
  double radius = 0;
};

// `plane_normal`: unit vector across the plane that the curve lies in.
Solid tube(const std::vector<TubePoint>& curve, Vec3 plane_normal, int corners,
           Ends ends = Ends::capped);
// Of one radius, in a level plane.
Solid tube(const std::vector<Vec3>& curve, double radius, int corners, Ends ends = Ends::capped);
// Level, of 12 corners.
Solid torus(Vec3 centre, double radius, double bar_radius, int steps);

// Centered at the origin.
Solid box(Vec3 size);

Solid joined(const std::vector<Solid>& parts);
Solid moved(Solid solid, const Pose& pose);

// Points at equal steps of angle, both ends included; from the x axis towards y.
std::vector<Vec3> arc(Vec3 centre, double radius, double from_rad, double to_rad, int steps);

// Cubic, both ends included.
std::vector<Vec3> bezier(const std::array<Vec3, 4>& control, int steps);

// Lying or standing on the bottom z = 0: its lowest point is at z = 0, the origin is below the
// middle of its bounding box, and the longest edge of that box is `size_m`.
Mesh model_mesh(ModelKind kind, double size_m);

// In any unit and position; up is as in model_mesh.
Solid bottle_solid();     // lies, axis x
Solid can_solid();        // lies, axis x
Solid tyre_solid();       // lies flat, axis z
Solid chain_solid();      // lies in a bend along x
Solid hook_solid();       // lies flat, eye towards x
Solid propeller_solid();  // lies flat, axis z
Solid valve_solid();      // stands, pipe along x, wheel on top
Solid carton_solid();     // lies on its largest face
Solid shackle_solid();    // lies flat, bow towards x
Solid wall_solid();       // stands, length along x
Solid pipe_solid();       // lies, axis x
Solid crab_pot_solid();   // stands, entrances along y
Solid ladder_solid();     // lies flat, stiles along x
Solid net_solid();        // lies in folds across x

}  // namespace ensonify
