// Sound in water: how fast it is, and what a path takes from it.
//
//   SeaWater  sound_speed_m_s  water_density_kg_m3
//   francois_garrison_db_m  ainslie_mccolm_db_m   absorption
//   two_way_loss  path_loss                       of a path out and back in homogeneous water
//   two_way_delay_s  carrier_turns
#pragma once

#include <cmath>

#include "core/compile_targets.h"

namespace ensonify {

struct SeaWater {
  double temperature_c = 10;
  double salinity_psu = 35;
  double ph = 8;
  double depth_m = 0;
};

// Absorption in dB/m: boric acid, magnesium sulfate and pure water. Francois and Garrison, "Sound
// absorption based on ocean measurements", JASA 72 (1982), parts I and II. Valid for 0.2-1000 kHz,
// -2..22 C, 30-35 psu, down to 3500 m; above 1 MHz the water term is extrapolated.
double francois_garrison_db_m(double frequency_hz, const SeaWater& water);

// The same absorption in a simpler form. Ainslie and McColm, "A simplified formula for viscous and
// chemical absorption in sea water", JASA 103 (1998): within a tenth of Francois and Garrison's for
// 0.1-1000 kHz, -6..35 C, 5-50 psu, pH 7.7-8.3, down to 7 km.
double ainslie_mccolm_db_m(double frequency_hz, const SeaWater& water);

// Sound speed; pH does not matter. Leroy, Robinson and Goldsmith, "A new equation for the accurate
// calculation of sound speed in all oceans", JASA 124 (2008), at 45 degrees of latitude (its term
// for latitude is at most 0.11 m/s in the upper 2 km): -1..30 C, 0-42 psu, down to 12 km.
double sound_speed_m_s(const SeaWater& water);

// Density at the pressure of the depth; pH does not matter. UNESCO, "Algorithms for computation of
// fundamental properties of seawater" (Fofonoff and Millard, 1983): -2..40 C, 0-42 psu, down to
// 10 km. The pressure is that of a column of 1025 kg/m^3, which changes the result by less than
// 1e-3.
double water_density_kg_m3(const SeaWater& water);

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
