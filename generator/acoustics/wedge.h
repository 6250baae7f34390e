// Diffraction by the edge of a rigid or soft wedge.
//
//   Wedge  wedge_diffraction   back toward the source
//   kirchhoff_edge             the part that Kirchhoff's integral over the faces contains
//   fringe_diffraction         the rest
#pragma once

namespace ensonify {

// Two plane faces that meet at the exterior angle `exterior_rad`, above pi and at most 2 pi.
struct Wedge {
  double exterior_rad = 0;
  bool rigid = true;  // otherwise soft
};

// Keller's coefficient f back toward a source at the angle phi from one face, 0 ... exterior_rad,
// across the edge. An edge element dl has the amplitude f dl/(2 pi), in m
// (Ufimtsev, Fundamentals of the Physical Theory of Diffraction, 2007, chapters 2 and 4):
//   f = sin(pi/n)/n [1/(cos(pi/n) - 1) +- 1/(cos(pi/n) - cos(2 phi/n))],  exterior_rad = n pi,
// + rigid, - soft. Infinite where a face is seen at normal incidence.
double wedge_diffraction(const Wedge& wedge, double angle_rad);

// The same by Kirchhoff's integral: -+ tan(phi)/2 for each face that the source sees, where phi is
// the angle from this face.
double kirchhoff_edge(const Wedge& wedge, double angle_rad);

// wedge_diffraction - kirchhoff_edge: what is added to Kirchhoff's integral. Finite everywhere.
double fringe_diffraction(const Wedge& wedge, double angle_rad);

}  // namespace ensonify
