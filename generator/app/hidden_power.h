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
// sum_i B(i - j)^2 / N_j^2 in beam j, of an array S0^2 sum_i |sum_n weight_n response_n E(u_i)
// e^(i 2 pi f_c y_n (sin theta_i - sin theta_j) / c)|^2; and |s(t)|^2.
HiddenPower hidden_power(const Sonar& sonar, const Water& water, const Record& record);

}  // namespace ensonify
