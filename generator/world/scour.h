// Scour: the pit that flowing water digs around an object, and the mound beyond it.
//
//   ScourShape  scour_shape   of an object, from its outline
//   scour_m                   change of height at a point
//   scour                     of a height grid
//   ScouredTerrain  scoured_terrain  scour_terrain   of a world
#pragma once

#include <map>
#include <optional>
#include <string>

#include "scenario/path_spec.h"
#include "world/outline.h"
#include "world/terrain.h"
#include "world/world.h"

namespace ensonify {

struct Scenario;

// With the distance d from the outline and the angle a between the outward normal and the flow:
//   pit    -depth p(a) sin^2(pi d / width)                          0 < d < width
//   mound   mound q(a) sin^2(pi (d - width) / mound_width)          beyond, up to its width
// where p = (1 - cos a) / 2 and q = (1 + cos a) / 2; p = q = 1 without a flow. The ground under the
// object does not change. By Steiner's formula, the curve at the distance d from a convex outline
// of perimeter L has the length L + 2 pi d, and the mean of cos a over it is 0. Therefore pit and
// mound have the same volume if
//   mound m (L + 2 pi width + pi m) = depth width (L + pi width),  m = mound_width.
struct ScourShape {
  double depth_m = 0, width_m = 0, mound_m = 0, mound_width_m = 0;
  std::optional<double> flow_rad;  // its direction in the world, positive from x to y
};

ScourShape scour_shape(const ScourSpec& spec, const Outline& outline);

// `from_outline` is the gap from the outline to the point.
double scour_m(const ScourShape& shape, const Gap& from_outline);

// Heights of terrain at that pose, along its own z, around an outline in the world.
void scour(const ScourSpec& spec, const Outline& outline, const Pose& terrain, HeightGrid& grid);

// Terrain with scour around objects, by name; initially only the names.
using ScouredTerrain = std::map<std::string, Terrain, std::less<>>;
ScouredTerrain scoured_terrain(const Scenario& scenario);

// Adds scour around all placed objects, which keep their poses. Needs the grids of all names.
void scour_terrain(const Scenario& scenario, ScouredTerrain& scoured, World& world);

}  // namespace ensonify
