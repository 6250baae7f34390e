// The sonar of most tests.
//
//   fan_sonar   any fan of it
//   p900        that of the closed forms, one ray of elevation
#pragma once

#include "core/sonar.h"
#include "core/units.h"

namespace ensonify::test {

// 900 kHz, 29.9 kHz, 1 deg x 20 deg, SL 220: `beams` x `rays` cells over fov x fan.
inline Sonar fan_sonar(int beams, double fov_rad, double range_max_m, int rays,
                       double fan_rad = radians(20)) {
  Sonar sonar;
  sonar.frequency_hz = 900e3;
  sonar.bandwidth_hz = 29.9e3;
  sonar.source_level_db = 220;
  sonar.range_max_m = range_max_m;
  sonar.beam_count = beams;
  sonar.beam_spacing_rad = fov_rad / beams;
  sonar.beam_width_rad = radians(1);
  sonar.elevation_width_rad = radians(20);
  sonar.elevation_fan_rad = fan_rad;
  sonar.rays_elevation = rays;
  return sonar;
}

inline Sonar p900(int beams, double fov_deg, double range_max_m) {
  return fan_sonar(beams, radians(fov_deg), range_max_m, 1);
}

}  // namespace ensonify::test
