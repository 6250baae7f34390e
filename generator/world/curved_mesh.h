// Smooth bodies from the flat triangles that stand for them.
//
//   facet_sag     how far the facets depart from that body
//   curved_mesh   the body as triangles that follow it closely enough for its phase
#pragma once

#include <cstddef>

#include "core/error.h"
#include "world/mesh.h"

namespace ensonify {

// The side of a triangle may depart from the smooth body by this share of the wavelength, and its
// middle by twice as much. Specular echoes of spheres and cylinders are then within 0.3 dB in every
// attitude; with 1/32 they are within 1.2 dB.
inline constexpr double kSag_wavelengths = 1.0 / 128;

// The largest distance between a side of a triangle and the smooth body, and that side.
struct FacetSag {
  double sag_m = 0;
  double side_m = 0;
  double radius_m = 0;  // of the body along the side
};
FacetSag facet_sag(const Mesh& mesh);

// The body in triangles that follow it to kSag_wavelengths. Triangles that are flat enough stay
// whole; the others are divided, and their new vertices lie on
//
//   p + Q/(1 + |n|) n/|n|,  p = sum l_i p_i,  n = sum l_i n_i,
//   Q = sum_{i<j} l_i l_j (n_j - n_i)(p_j - p_i)
//
// with the barycentric coordinates l_i, which is exact for spheres and circular cylinders and right
// to second order for other bodies. Sides are common to both of their triangles, at edges of the
// body as well, so that no gap opens. Normals, reflectivity and texture coordinates are
// interpolated. Faces may turn either way around. Error (usage): more than kMostCurvedTriangles
// would be needed.
inline constexpr std::size_t kMostCurvedTriangles = 16'000'000;
Result<Mesh> curved_mesh(const Mesh& mesh, double wavelength_m);

}  // namespace ensonify
