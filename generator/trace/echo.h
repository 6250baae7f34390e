// What of an echo follows from its place alone.
#pragma once

#include <cmath>

#include "acoustics/propagation.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "trace/bent.h"

namespace ensonify {

// A finite number above zero within [range_min, range_max].
inline bool in_range(double range_m, const Sonar& sonar) {
  return std::isfinite(range_m) && range_m > 0 && range_m >= sonar.range_min_m &&
         range_m <= sonar.range_max_m;
}

// What an echo's direction brings: worked out once where many echoes share it.
struct EchoDirection {
  double azimuth_rad = 0, elevation_rad = 0;
  Vec3 unit;
  double elevation_pattern = 1, transmit_pattern = 1;
};
EchoDirection echo_direction(double azimuth_rad, double elevation_rad, const Sonar& sonar);

// Delay 2r/c, place, directions, sector, and the gain r^-2 10^(-absorption 2r/20) B_el(elevation)
// B_tx(azimuth). Amplitude, instance and key are the caller's.
inline void set_echo(double range_m, const EchoDirection& direction, std::uint32_t beam,
                     const Water& water, Scatterer& s) {
  s.delay_s = two_way_delay_s(range_m, water.sound_speed_m_s);
  s.position_m = range_m * direction.unit;
  s.arrival = {static_cast<float>(direction.azimuth_rad),
               static_cast<float>(direction.elevation_rad)};
  s.departure = s.arrival;
  s.gain = static_cast<float>(two_way_loss(range_m, water.absorption_db_m) *
                              direction.elevation_pattern * direction.transmit_pattern);
  s.beam = beam;
  s.received_path_m = static_cast<float>(range_m);
}

// What a bent way changes of it: the place, the gain, the curvature of what comes back.
inline void set_bent(const RayPath& path, const EchoDirection& direction, const Water& water,
                     Scatterer& s) {
  constexpr double kLn10 = 2.302585092994045684;
  s.position_m = path.position_m;
  s.gain = static_cast<float>(std::exp(-water.absorption_db_m * path.length_m * (kLn10 / 10.0)) /
                              path.spreading_m2 * direction.elevation_pattern *
                              direction.transmit_pattern);
  s.received_path_m = static_cast<float>(path.curvature_radius_m);
}
Scatterer echo_from(double range_m, double azimuth_rad, double elevation_rad, int beam,
                    const Sonar& sonar, const Water& water);

}  // namespace ensonify
