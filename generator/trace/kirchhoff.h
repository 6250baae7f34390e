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
// neighbour's, meets such a surface is taken on its own if the surface's plane at its middle
// predicts the ranges at its four corners to 0.1 rad of two-way phase; otherwise it is cut in four
// and each part is traced again, and so on. Parts that a body's edge runs through are cut down to
// a quarter of a wavelength (as wide as at their range); then their middle decides.
// In a fixed order, whatever the workers. `hits` in the order of ray_index.
std::vector<Scatterer> kirchhoff_scatterers(const Fan& fan, std::span<const Hit> hits,
                                            const Tracer& tracer, const Pose& sonar_in_world,
                                            const SurfaceScattering& scattering,
                                            const Workers& workers);

}  // namespace ensonify
