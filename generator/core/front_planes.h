// The planes of a front view, one row each, and the directions of its pixels. All code that writes,
// checks or reads front views loops over this table.
//
//   FrontPlane  kFrontPlanes  is_float_plane
//   with_plane                calls a function with the values of a plane
//   ray_elevations_rad  ray_azimuths_rad   the rays of the fan, at the middles of their cells
#pragma once

#include <cstdint>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/image_planes.h"
#include "core/ping.h"
#include "core/sonar.h"

namespace ensonify {

struct FrontPlane {
  using Values =
      std::variant<std::vector<float> FrontView::*, std::vector<std::uint16_t> FrontView::*,
                   std::vector<std::uint8_t> FrontView::*>;
  const char* name;
  const char* unit;
  PlaneBlank blank;
  Values values;
  double file_bytes;  // of a pixel on disk, as typical views have them
  const char* meaning;
};

inline constexpr FrontPlane kFrontPlanes[] = {
    {"range_m", "m", PlaneBlank::nan, &FrontView::range_m, 1.2,
     "Slant range; with refraction c times the one-way travel time."},
    {"normal_x", "1", PlaneBlank::nan, &FrontView::normal_x, 1.2,
     "Unit normal of the surface, along the boresight; see `normal`."},
    {"normal_y", "1", PlaneBlank::nan, &FrontView::normal_y, 1.2,
     "Unit normal of the surface, to port."},
    {"normal_z", "1", PlaneBlank::nan, &FrontView::normal_z, 1.2,
     "Unit normal of the surface, up."},
    {"backscatter_db", "dB re 1 m^2/m^2", PlaneBlank::nan, &FrontView::backscatter_db, 1.2,
     "Backscatter per unit of surface at the ray's incidence, dB re 1 m^2/m^2; -99: none."},
    {"instance", "", PlaneBlank::zero, &FrontView::instance, 0.05, "Instance ids; 0: none."},
    {"semantic", "", PlaneBlank::zero, &FrontView::semantic, 0.05,
     "Class ids; id k is `classes[k - 1]`, 0: none."},
};

// Each float plane is a channel of the view's EXR file.
constexpr bool is_float_plane(const FrontPlane& plane) { return plane.values.index() == 0; }

template <class View, class Use>
decltype(auto) with_plane(View& view, const FrontPlane& plane, Use&& use) {
  return std::visit([&](auto member) -> decltype(auto) { return use(view.*member); }, plane.values);
}

// [rays_elevation], lowest first.
inline std::vector<double> ray_elevations_rad(const Sonar& sonar) {
  const double step_rad = sonar.elevation_fan_rad / sonar.rays_elevation;
  std::vector<double> elevations_rad;
  for (int e = 0; e < sonar.rays_elevation; ++e) {
    elevations_rad.push_back(-sonar.elevation_fan_rad / 2 + e * step_rad + step_rad / 2);
  }
  return elevations_rad;
}

// [beams x rays_azimuth], beam 0 first.
inline std::vector<double> ray_azimuths_rad(const Sonar& sonar) {
  std::vector<double> azimuths_rad;
  for (int j = 0; j < sonar.beam_count; ++j) {
    const double middle_rad = cell_middle_rad(sonar, j);
    const double step_rad = cell_width_rad(sonar, j) / sonar.rays_azimuth;
    for (int a = 0; a < sonar.rays_azimuth; ++a) {
      azimuths_rad.push_back(middle_rad + (a - (sonar.rays_azimuth - 1) / 2.0) * step_rad);
    }
  }
  return azimuths_rad;
}

}  // namespace ensonify
