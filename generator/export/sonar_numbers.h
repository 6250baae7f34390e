// Numbers of the sonar equation that SONAR-netCDF4 asks for, from the model of the sonar. Private
// to export/.
//
//   one_way_elevation_width_rad   of the transmit and of the receive pattern
//   equivalent_beam_angle_sr      of a beam
//   effective_pulse_s             of the received pulse
#pragma once

#include "core/ping.h"

namespace ensonify {

// -3 dB width of a pattern whose square is the two-way elevation pattern.
double one_way_elevation_width_rad(const Sonar& sonar);

// The integral over all directions ahead of the two-way power pattern, which is 1 on the beam's
// axis:
//   psi = 1/T(theta_j)^2 int B(theta - theta_j)^2 T(theta)^2 d theta  int B_el(phi)^2 cos phi d phi
// with the patterns of acoustics/pattern.h, and the pattern of a shaded line for arrays.
double equivalent_beam_angle_sr(const Sonar& sonar, int beam);

// Duration of the rectangular pulse with the same peak and energy: int |s|^2 dt / max |s|^2.
double effective_pulse_s(const SequenceInfo& info);

}  // namespace ensonify
