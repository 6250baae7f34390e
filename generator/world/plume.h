// Bubble plumes: a procedural density field.
#pragma once

#include <cstdint>

#include "core/error.h"
#include "core/vec.h"
#include "scenario/volume_spec.h"
#include "world/density.h"

namespace ensonify {

// R(z) = radius + z tan(spread).
double plume_radius_m(const PlumeSpec& plume, double z_m);

// (radius/R)^2 (1 - s^2/R^2)^2 at distance s from the axis, falling to zero over the uppermost
// fifth; zero outside. 1 on the axis at the foot.
double plume_mean_density(const PlumeSpec& plume, Vec3 p);

// The mean times turbulence: exp(sigma g - sigma^2/2), g a normal field of unit variance
// everywhere, three octaves of eddies that grow with R. The mean over keys is plume_mean_density.
// Error (usage): a plume so wide above a foot so narrow that the grid does not resolve it.
Result<DensityGrid> make_plume(const PlumeSpec& plume, std::uint64_t key);

}  // namespace ensonify
