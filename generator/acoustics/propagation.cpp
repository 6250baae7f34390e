#include "acoustics/propagation.h"

#include <cmath>

namespace ensonify {
namespace {

// One relaxation: A P f_r f^2 / (f^2 + f_r^2), frequencies in kHz, dB/km.
double relaxation_db_km(double amplitude, double relaxation_khz, double frequency_khz) {
  const double f2 = frequency_khz * frequency_khz;
  return amplitude * relaxation_khz * f2 / (f2 + relaxation_khz * relaxation_khz);
}

double pure_water_coefficient(double t) {
  if (t <= 20) return 4.937e-4 + t * (-2.59e-5 + t * (9.11e-7 - t * 1.50e-8));
  return 3.964e-4 + t * (-1.146e-5 + t * (1.45e-7 - t * 6.5e-10));
}

}  // namespace

double francois_garrison_db_m(double frequency_hz, const SeaWater& water) {
  const double f = frequency_hz / 1000.0;
  const double t = water.temperature_c;
  const double s = water.salinity_psu;
  const double d = water.depth_m;
  const double kelvin = 273.0 + t;
  const double sound_speed = 1412.0 + 3.21 * t + 1.19 * s + 0.0167 * d;

  const double boric = 8.86 / sound_speed * std::pow(10.0, 0.78 * water.ph - 5.0);
  const double boric_khz = 2.8 * std::sqrt(s / 35.0) * std::pow(10.0, 4.0 - 1245.0 / kelvin);

  const double sulphate = 21.44 * s / sound_speed * (1.0 + 0.025 * t);
  const double sulphate_pressure = 1.0 + d * (-1.37e-4 + d * 6.2e-9);
  const double sulphate_khz =
      8.17 * std::pow(10.0, 8.0 - 1990.0 / kelvin) / (1.0 + 0.0018 * (s - 35.0));

  const double water_pressure = 1.0 + d * (-3.83e-5 + d * 4.9e-10);

  const double db_km = relaxation_db_km(boric, boric_khz, f) +
                       relaxation_db_km(sulphate * sulphate_pressure, sulphate_khz, f) +
                       pure_water_coefficient(t) * water_pressure * f * f;
  return db_km / 1000.0;
}

double ainslie_mccolm_db_m(double frequency_hz, const SeaWater& water) {
  const double f = frequency_hz / 1000.0;
  const double t = water.temperature_c;
  const double s = water.salinity_psu;
  const double z = water.depth_m / 1000.0;
  const double boric_khz = 0.78 * std::sqrt(s / 35.0) * std::exp(t / 26.0);
  const double sulphate_khz = 42.0 * std::exp(t / 17.0);
  const double db_km =
      relaxation_db_km(0.106 * std::exp((water.ph - 8.0) / 0.56), boric_khz, f) +
      relaxation_db_km(0.52 * (1.0 + t / 43.0) * (s / 35.0) * std::exp(-z / 6.0), sulphate_khz, f) +
      0.00049 * f * f * std::exp(-(t / 27.0 + z / 17.0));
  return db_km / 1000.0;
}

double sound_speed_m_s(const SeaWater& water) {
  const double t = water.temperature_c;
  const double s = water.salinity_psu;
  const double z = water.depth_m;
  return 1402.5 + t * (5.0 + t * (-5.44e-2 + t * 2.1e-4)) + 1.33 * s - 1.23e-2 * s * t +
         8.7e-5 * s * t * t + z * (1.56e-2 + z * (2.55e-7 - z * 7.3e-12)) -
         9.5e-13 * t * z * z * z + 3e-7 * t * t * z + 1.43e-5 * s * z;
}

namespace {

// At the pressure of the atmosphere.
double surface_density_kg_m3(double t, double s) {
  const double fresh =
      999.842594 +
      t * (6.793952e-2 +
           t * (-9.095290e-3 + t * (1.001685e-4 + t * (-1.120083e-6 + t * 6.536332e-9))));
  return fresh +
         s * (8.24493e-1 + t * (-4.0899e-3 + t * (7.6438e-5 + t * (-8.2467e-7 + t * 5.3875e-9)))) +
         s * std::sqrt(s) * (-5.72466e-3 + t * (1.0227e-4 - t * 1.6546e-6)) + 4.8314e-4 * s * s;
}

// How pressure compresses the water: the density is that at the surface / (1 - pressure / modulus).
double bulk_modulus_bar(double t, double s, double pressure_bar) {
  const double s32 = s * std::sqrt(s);
  const double fresh =
      19652.21 + t * (148.4206 + t * (-2.327105 + t * (1.360477e-2 - t * 5.155288e-5)));
  const double at_surface = fresh +
                            s * (54.6746 + t * (-0.603459 + t * (1.09987e-2 - t * 6.1670e-5))) +
                            s32 * (7.944e-2 + t * (1.6483e-2 - t * 5.3009e-4));
  const double linear = 3.239908 + t * (1.43713e-3 + t * (1.16092e-4 - t * 5.77905e-7)) +
                        s * (2.2838e-3 + t * (-1.0981e-5 - t * 1.6078e-6)) + 1.91075e-4 * s32;
  const double square = 8.50935e-5 + t * (-6.12293e-6 + t * 5.2787e-8) +
                        s * (-9.9348e-7 + t * (2.0816e-8 + t * 9.1697e-10));
  return at_surface + pressure_bar * (linear + pressure_bar * square);
}

}  // namespace

double water_density_kg_m3(const SeaWater& water) {
  constexpr double kBarPerMeter = 1025 * 9.81 * 1e-5;
  const double pressure_bar = kBarPerMeter * water.depth_m;
  const double t = water.temperature_c, s = water.salinity_psu;
  return surface_density_kg_m3(t, s) / (1 - pressure_bar / bulk_modulus_bar(t, s, pressure_bar));
}

}  // namespace ensonify
