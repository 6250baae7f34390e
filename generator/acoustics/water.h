// Sea water: absorption and speed of sound.
//
//   SeaWater
//   francois_garrison_db_m  ainslie_mccolm_db_m   absorption
//   sound_speed_m_s
#pragma once

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

}  // namespace ensonify
