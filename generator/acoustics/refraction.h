// Rays in water whose sound speed changes with height: closed forms in layers of constant gradient.
//
//   SoundLayers   make_layers sound_speed_at bends
//   RayPoint      a point of a ray: position, direction, travel time, path, spreading
//   RayArc        start_ray next_arc point_on   a ray, layer by layer
//   ray_at_distance                             where a ray passes a horizontal distance
//   find_eigenray                               from one point to another
//   tube_area_m2  two_way_spreading_m2
//
// A ray stays in the vertical plane in which it starts. x is the horizontal distance from there, z
// the height in the world, phi the elevation of its direction. p = cos(phi)/c is constant along it
// (Snell), and in a layer of gradient g = dc/dz the ray is an arc of a circle of curvature g p:
// dphi/ds = -g p. All formulas use the path length s along the arc and lose no digits as g goes to
// 0, where the arc becomes a straight line; phi = +-90 degrees is no special case. Jensen,
// Kuperman, Porter and Schmidt, "Computational Ocean Acoustics" (2011), chapter 3.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "core/sonar.h"

namespace ensonify {

// Layer k extends from z_m[k - 1] to z_m[k]; the lowest and the highest layer are unbounded and
// have no gradient.
struct SoundLayers {
  std::vector<double> z_m;         // borders, rising
  std::vector<double> speed_m_s;   // [borders]
  std::vector<double> gradient_s;  // [borders + 1], dc/dz in 1/s
  double fastest_m_s = 0;
};

// Needs at least one row, rising depths and speeds above zero.
SoundLayers make_layers(const SoundProfile& profile);

double sound_speed_at(const SoundLayers& layers, double z_m);

// Whether rays and travel times differ from those at the instrument's own sound speed.
bool bends(const Water& water);

// A neighboring ray that starts dphi higher lies spread_m dphi to the side of this one (above it,
// for a horizontal ray). One that starts dtheta to the left lies lateral_m cos(phi_0) dtheta to the
// left. Both lengths are s in constant water.
struct RayPoint {
  double x_m = 0, z_m = 0;
  double cos_phi = 1, sin_phi = 0;
  double speed_m_s = 0;
  double time_s = 0, path_m = 0;
  double lateral_m = 0;  // x / cos(phi_0) = int c ds / c_0, also where the ray is vertical
  double spread_m = 0;   // changes sign at a caustic
};

struct RayArc {
  RayPoint start;
  int layer = 0;
  double gradient_s = 0, curvature_m = 0;  // dc/dz; -dphi/ds, in 1/m
  double opening = 0;                      // d spread / ds / c: constant in a layer
  double source_speed_m_s = 0;
  double length_m = 0;  // to the layer's border; infinite if the ray stays in the layer
  bool leaves_up = false;
};

// cos_phi >= 0, cos_phi^2 + sin_phi^2 = 1.
RayArc start_ray(const SoundLayers& layers, double z_m, double cos_phi, double sin_phi);

// The arc behind the border at which an arc of finite length ends. A ray that would swing around a
// border by less than a nanometer follows the border.
RayArc next_arc(const SoundLayers& layers, const RayArc& arc);

// The point at path length s from the start of the arc, at most half a circle away. Outside the arc
// the same circle continues, as if the layer did. With the chord d, the travel time is
// (2/g) asinh(g d / (2 sqrt(c_1 c_2))) = (1/g) acosh(1 + g^2 d^2/(2 c_1 c_2)).
RayPoint point_on(const RayArc& arc, double s_m);

// The point at which the ray passes x_m >= 0. None if it never does, like a vertical ray.
std::optional<RayPoint> ray_at_distance(const SoundLayers& layers, RayArc arc, double x_m);

// A / dOmega: the cross-section of a thin tube of rays divided by its solid angle at the start; s^2
// in constant water.
inline double tube_area_m2(const RayPoint& point) {
  return point.lateral_m * std::abs(point.spread_m);
}

// Replaces r^2 in the two-way loss: sqrt(A_out/dOmega . A_back/dOmega) = (c_0/c) A_out/dOmega by
// reciprocity, but at least (k r)^(-1/3) of its value without focusing, where r = lateral_m. At a
// caustic, where rays cross and A is 0, this limit is the strength of the wave (Airy's function).
double two_way_spreading_m2(const RayPoint& point, double source_speed_m_s, double frequency_hz);

struct Eigenray {
  double cos_phi = 1, sin_phi = 0;  // at the start
  RayPoint end;
};

// The ray from a point at height z_m to one at height end_z_m, at a horizontal distance x_m >= 0.
// Newton's method starts from the straight direction and stays between two rays that pass on either
// side. If several rays reach the point, the fastest one is returned: if the first ray found has
// passed a caustic, which the fastest never has, all directions are searched in steps of half a
// degree. None if the point lies in a shadow zone.
std::optional<Eigenray> find_eigenray(const SoundLayers& layers, double z_m, double x_m,
                                      double end_z_m);

}  // namespace ensonify
