// What the models are put together from: closed solids in double precision.
//
//   Solid          triangles; parts side by side
//   loft           skin over a row of rings: what the others are made of
//   turned         a profile turned about z
//   tube           a circle led along a plane curve
//   box
//   joined  moved  several as one; elsewhere
//   arc  bezier    points of plane curves
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/vec.h"

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

// All rings have as many points. Either way round will do: faces are turned to look outwards.
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

// Centred at the origin.
Solid box(Vec3 size);

Solid joined(const std::vector<Solid>& parts);
Solid moved(Solid solid, const Pose& pose);

// Points at equal steps of angle, both ends included; from the x axis towards y.
std::vector<Vec3> arc(Vec3 centre, double radius, double from_rad, double to_rad, int steps);

// Cubic, both ends included.
std::vector<Vec3> bezier(const std::array<Vec3, 4>& control, int steps);

}  // namespace ensonify
