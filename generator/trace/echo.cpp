#include "trace/echo.h"

#include "acoustics/pattern.h"

namespace ensonify {

EchoDirection echo_direction(double azimuth_rad, double elevation_rad, const Sonar& sonar) {
  return {azimuth_rad, elevation_rad, unit_vector(azimuth_rad, elevation_rad),
          line_pattern(elevation_rad, sonar.elevation_width_rad),
          transmit_pattern(azimuth_rad, sonar.transmit_width_rad)};
}

Scatterer echo_from(double range_m, double azimuth_rad, double elevation_rad, int beam,
                    const Sonar& sonar, const Water& water) {
  Scatterer s;
  set_echo(range_m, echo_direction(azimuth_rad, elevation_rad, sonar),
           static_cast<std::uint32_t>(beam), water, s);
  return s;
}

}  // namespace ensonify
