// Loss and delay of the path out and back in homogeneous water.
#pragma once

#include <cmath>

#include "core/host_device.h"

namespace ensonify {

// r^-2 10^(-alpha 2r / 20), amplitude in 1/m^2: spherical spreading and absorption out and back
// (Choi et al. 2021, Eq 8).
ENSONIFY_HD inline double two_way_loss(double range_m, double absorption_db_m) {
  constexpr double kLn10 = 2.302585092994045684;  // exp is half the time of pow
  return std::exp(-absorption_db_m * range_m * (kLn10 / 10.0)) / (range_m * range_m);
}

// The same for different paths out and back: 10^(-alpha (r_out + r_back) / 20) / (r_out r_back).
ENSONIFY_HD inline double path_loss(double out_m, double back_m, double absorption_db_m) {
  constexpr double kLn10 = 2.302585092994045684;
  return std::exp(-absorption_db_m * (out_m + back_m) * (kLn10 / 20.0)) / (out_m * back_m);
}

// tau = 2r / c.
ENSONIFY_HD inline double two_way_delay_s(double range_m, double sound_speed_m_s) {
  return 2.0 * range_m / sound_speed_m_s;
}

// The fraction of a turn that the carrier makes in a delay, in (-1/2, 1/2]. Reduced in double:
// 900 kHz over 60 m is 72,000 turns, of which a float would keep two digits.
ENSONIFY_HD inline double carrier_turns(double frequency_hz, double delay_s) {
  const double turns = frequency_hz * delay_s;
  return turns - std::rint(turns);
}

}  // namespace ensonify
