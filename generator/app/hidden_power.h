// On what scale hidden echoes are weighed against the noise.
#pragma once

#include <vector>

#include "core/sonar.h"

namespace ensonify {

// labels/shadow.h's power_per_energy and pulse_power.
struct HiddenPower {
  std::vector<double> per_energy, pulse;
};

// The clean power of a pixel whose neighbours in azimuth hold as much energy as it does: S0^2
// sum_i B(i - j)^2 / N_j^2 in beam j; and |s(t)|^2.
HiddenPower hidden_power(const Sonar& sonar, const Record& record);

}  // namespace ensonify
