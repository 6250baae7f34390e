// What of an echo follows from its place alone.
#pragma once

#include "core/scatterers.h"
#include "core/sonar.h"

namespace ensonify {

// A finite number above zero within [range_min, range_max].
bool in_range(double range_m, const Sonar& sonar);

// Delay 2r/c, place, directions, sector, and the gain r^-2 10^(-absorption 2r/20) B_el(elevation)
// B_tx(azimuth). Amplitude, instance and key are the caller's.
Scatterer echo_from(double range_m, double azimuth_rad, double elevation_rad, int beam,
                    const Sonar& sonar, const Water& water);

}  // namespace ensonify
