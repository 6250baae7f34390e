// The dense fan of rays: every sector cut into cells of azimuth and elevation, a ray through the
// middle of each.
//
//   Fan       make_fan
//   ray_index the order of rays: beam, then azimuth, then elevation
#pragma once

#include <cstdint>
#include <vector>

#include "core/sonar.h"

namespace ensonify {

struct Fan {
  int beams = 0, rays_azimuth = 0, rays_elevation = 0;
  std::vector<double> azimuth_rad;     // [beams x rays_azimuth], middles of the cells
  std::vector<double> elevation_rad;   // [rays_elevation], lowest first
  std::vector<double> solid_angle_sr;  // [rays_elevation], exact, the same for every azimuth

  std::size_t size() const { return azimuth_rad.size() * elevation_rad.size(); }
  std::size_t rays_per_beam() const { return std::size_t(rays_azimuth) * rays_elevation; }
};

Fan make_fan(const Sonar& sonar);

inline std::size_t ray_index(const Fan& fan, int beam, int azimuth, int elevation) {
  return (std::size_t(beam) * fan.rays_azimuth + azimuth) * fan.rays_elevation + elevation;
}

}  // namespace ensonify
