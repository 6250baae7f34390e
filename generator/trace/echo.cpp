#include "trace/echo.h"

#include <cmath>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"

namespace ensonify {

bool in_range(double range_m, const Sonar& sonar) {
  return std::isfinite(range_m) && range_m > 0 && range_m >= sonar.range_min_m &&
         range_m <= sonar.range_max_m;
}

Scatterer echo_from(double range_m, double azimuth_rad, double elevation_rad, int beam,
                    const Sonar& sonar, const Water& water) {
  Scatterer s;
  s.delay_s = two_way_delay_s(range_m, water.sound_speed_m_s);
  s.position_m = range_m * unit_vector(azimuth_rad, elevation_rad);
  s.arrival = {static_cast<float>(azimuth_rad), static_cast<float>(elevation_rad)};
  s.departure = s.arrival;
  s.gain = static_cast<float>(two_way_loss(range_m, water.absorption_db_m) *
                              line_pattern(elevation_rad, sonar.elevation_width_rad) *
                              transmit_pattern(azimuth_rad, sonar.transmit_width_rad));
  s.beam = static_cast<std::uint32_t>(beam);
  return s;
}

}  // namespace ensonify
