// Mirrors: the coherent echo of smooth surfaces, by Kirchhoff's approximation.
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/scatter.h"

namespace ensonify {

// The coherent scatterers of all surfaces whose material says kirchhoff, without variance; the
// random part of the same surfaces is in surface_scatterers. Each cell of the fan whose ray, or a
// neighbour's, meets such a surface gets rays through its corners and the middles of its sides. It
// is taken on its own where the range is linear in both angles to 0.2 rad of two-way phase (the
// bend enters the amplitude to first order) and changes by no more than c/24b along either side.
// Otherwise it is cut in two across the side that asks for it, and so are the halves, down to a
// quarter of a wavelength. A part that a body's edge runs through is cut down to an eighth, to a
// thirty-second where the edge runs along its sides; then its middle decides. A body that all rays
// of the fan miss is not found.
// In a fixed order, whatever the workers. `hits` in the order of ray_index.
std::vector<Scatterer> kirchhoff_scatterers(const Fan& fan, std::span<const Hit> hits,
                                            const Tracer& tracer, const Pose& sonar_in_world,
                                            const SurfaceScattering& scattering,
                                            const Workers& workers);

}  // namespace ensonify
