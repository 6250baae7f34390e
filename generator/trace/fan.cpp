#include "trace/fan.h"

#include "acoustics/scattering.h"

namespace ensonify {

Fan make_fan(const Sonar& sonar) {
  Fan fan{sonar.beam_count, sonar.rays_azimuth, sonar.rays_elevation, {}, {}, {}};
  const double azimuth_step = sonar.beam_spacing_rad / sonar.rays_azimuth;
  for (int j = 0; j < sonar.beam_count; ++j) {
    for (int a = 0; a < sonar.rays_azimuth; ++a) {
      fan.azimuth_rad.push_back(beam_azimuth_rad(sonar, j) +
                                (a - (sonar.rays_azimuth - 1) / 2.0) * azimuth_step);
    }
  }
  const double elevation_step = sonar.elevation_fan_rad / sonar.rays_elevation;
  for (int e = 0; e < sonar.rays_elevation; ++e) {
    const double low = -sonar.elevation_fan_rad / 2 + e * elevation_step;
    fan.elevation_rad.push_back(low + elevation_step / 2);
    fan.solid_angle_sr.push_back(cell_solid_angle_sr(azimuth_step, low, low + elevation_step));
  }
  return fan;
}

}  // namespace ensonify
