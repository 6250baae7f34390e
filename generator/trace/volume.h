// Reverberation of the water itself, up to the first surface that each ray meets.
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/volume_echo.h"
#include "trace/scatter.h"

namespace ensonify {

// One echo a volume of the world, in its order. In sector j and sample n >= 1 of range r = c
// n/(2b), within [range_min, range_max]: s_v (sum over the sector's rays that reach r: dOmega
// B_el^2 B_tx^2) r^2 c/(2b) (two_way_loss)^2.
std::vector<VolumeEcho> volume_echoes(const Fan& fan, std::span<const Hit> hits,
                                      const std::vector<UniformVolume>& volumes, const Sonar& sonar,
                                      const Water& water, const Record& record,
                                      const Workers& workers);

}  // namespace ensonify
