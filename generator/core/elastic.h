// Elastic bodies and the echoes that they return, as the scenario, the world and the files state
// them.
//
//   SphereMaterial  SphereMetal  properties   what a body is made of
//   SphereFilling  ElasticBody
//   Tap                                       a delayed echo
#pragma once

#include <complex>

namespace ensonify {

// Speeds of longitudinal and of shear waves; a shear speed of 0 is a fluid. The shear speed is
// below sqrt(3/4) of the longitudinal one, so that the compressibility is positive.
struct SphereMaterial {
  double density_kg_m3 = 0, speed_m_s = 0, shear_speed_m_s = 0;

  bool operator==(const SphereMaterial&) const = default;
};

// Tungsten carbide with 6 % cobalt: MacLennan and Dunn, J. Sound Vib. 97, 1984. Electrical-grade
// copper: Foote, J. Acoust. Soc. Am. 73, 1983. Rolled aluminum and mild steel: CRC Handbook of
// Chemistry and Physics, section 14, speed of sound in solids.
inline constexpr SphereMaterial kTungstenCarbide{14900, 6853, 4171};
inline constexpr SphereMaterial kSteel{7850, 5960, 3235};
inline constexpr SphereMaterial kAluminum{2700, 6420, 3040};
inline constexpr SphereMaterial kCopper{8947, 4760, 2288.5};

enum class SphereMetal { tungsten_carbide, steel, aluminum, copper };
inline const char* name_of(SphereMetal metal) {
  constexpr const char* kNames[] = {"tungsten_carbide", "steel", "aluminum", "copper"};
  return kNames[static_cast<int>(metal)];
}
inline SphereMaterial properties(SphereMetal metal) {
  constexpr SphereMaterial kMaterials[] = {kTungstenCarbide, kSteel, kAluminum, kCopper};
  return kMaterials[static_cast<int>(metal)];
}

// The fluid in a shell; a density of 0 is a vacuum.
struct SphereFilling {
  double density_kg_m3 = 0, speed_m_s = 0;

  bool operator==(const SphereFilling&) const = default;
};
inline constexpr SphereFilling kAir{1.2, 340};

struct ElasticBody {
  double radius_m = 0;
  SphereMaterial material;
  double wall_m = 0;  // from the radius on: solid
  SphereFilling filling = {};

  bool is_solid() const { return !(wall_m < radius_m); }
  bool operator==(const ElasticBody&) const = default;
};

// The response gain e^(-i 2 pi f delay).
struct Tap {
  double delay_s = 0;
  std::complex<double> gain;
};

}  // namespace ensonify
