// Sea water: absorption of sound.
#pragma once

namespace ensonify {

struct SeaWater {
  double temperature_c = 10;
  double salinity_psu = 35;
  double ph = 8;
  double depth_m = 0;
};

// Absorption in dB/m: boric acid, magnesium sulphate and pure water. Francois and Garrison,
// "Sound absorption based on ocean measurements", JASA 72 (1982), parts I and II. Made for
// 0.2-1000 kHz, -2..22 C, 30-35 psu, down to 3500 m; above 1 MHz the water term carries on.
double francois_garrison_db_m(double frequency_hz, const SeaWater& water);

}  // namespace ensonify
