// Rays in water whose sound speed changes with height: closed forms in layers of constant gradient.
//
//   SoundLayers   make_layers sound_speed_at bends
//   RayPoint      a point of a ray: place, direction, travel time, path, spreading
//   RayArc        start_ray next_arc point_on   a ray, layer by layer
//   ray_at_distance                             where a ray passes a horizontal distance
//   find_eigenray                               from one point to another
//   tube_area_m2  two_way_spreading_m2
//
// A ray stays in the vertical plane in which it starts. x is the horizontal distance from there,
// z the height in the world, phi the elevation of its direction. p = cos(phi)/c is constant along
// it (Snell), and in a layer of gradient g = dc/dz the ray is an arc of a circle of curvature g p:
// dphi/ds = -g p. All is written by the path length s along the arc, in forms that lose no digits
// as g goes to 0, where the arc becomes a straight line; phi = +-90 degrees is no special case.
// Jensen, Kuperman, Porter and Schmidt, "Computational Ocean Acoustics" (2011), chapter 3.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "core/sonar.h"

namespace ensonify {

// Layer k reaches from z_m[k - 1] to z_m[k]; the lowest and the highest have no end and no
// gradient.
struct SoundLayers {
  std::vector<double> z_m;         // borders, rising
  std::vector<double> speed_m_s;   // [borders]
  std::vector<double> gradient_s;  // [borders + 1], dc/dz in 1/s
  double fastest_m_s = 0;
};

// Needs one row and more, depths that rise and speeds above zero.
SoundLayers make_layers(const SoundProfile& profile);

double sound_speed_at(const SoundLayers& layers, double z_m);

// Whether rays and travel times differ from those at the instrument's own sound speed.
bool bends(const Water& water);

// The neighbouring ray that starts dphi higher lies spread_m dphi to the side of this one (up, for
// a ray that goes level); the one that starts dtheta to the left lies lateral_m cos(phi_0) dtheta
// to its left. Both are s in constant water.
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
  double length_m = 0;  // to the layer's border; infinite where the ray stays in the layer
  bool leaves_up = false;
};

// cos_phi >= 0, cos_phi^2 + sin_phi^2 = 1.
RayArc start_ray(const SoundLayers& layers, double z_m, double cos_phi, double sin_phi);

// What follows behind the border that an arc of finite length ends at. A ray that would swing about
// a border by less than a nanometre goes along it.
RayArc next_arc(const SoundLayers& layers, const RayArc& arc);

// The point s behind the start of the arc, at most a half circle of it. Beyond the arc's ends: the
// same circle, as if the layer went on. Travel time: (2/g) asinh(g d / (2 sqrt(c_1 c_2))), d the
// chord, which is (1/g) acosh(1 + g^2 d^2/(2 c_1 c_2)).
RayPoint point_on(const RayArc& arc, double s_m);

// Where the ray passes x_m >= 0. None where it never does: a vertical ray.
std::optional<RayPoint> ray_at_distance(const SoundLayers& layers, RayArc arc, double x_m);

// A / dOmega: the cross-section of a thin tube of rays by the solid angle that it starts with; s^2
// in constant water.
inline double tube_area_m2(const RayPoint& point) {
  return point.lateral_m * std::abs(point.spread_m);
}

// What stands for r^2 in the two-way loss: sqrt(A_out/dOmega . A_back/dOmega) = (c_0/c)
// A_out/dOmega by reciprocity, and not less than (k r)^(-1/3) of what it would be without focusing,
// r = lateral_m: at a caustic, where rays cross and A is 0, waves are that loud (Airy's function)
// and no louder.
double two_way_spreading_m2(const RayPoint& point, double source_speed_m_s, double frequency_hz);

struct Eigenray {
  double cos_phi = 1, sin_phi = 0;  // at the start
  RayPoint end;
};

// From a point at height z_m to one at height end_z_m, x_m >= 0 aside: by Newton's method from the
// straight direction, kept between two rays that pass on either side. Of several rays that with the
// shortest travel time: where the first one found has passed a caustic, which the fastest never
// has, all directions are looked through in steps of half a degree. None where the point lies in
// shadow.
std::optional<Eigenray> find_eigenray(const SoundLayers& layers, double z_m, double x_m,
                                      double end_z_m);

}  // namespace ensonify
