// From one hit to its scatterer, and keys. Private to trace/.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "acoustics/scattering.h"
#include "core/error.h"
#include "trace/echo.h"
#include "trace/scatter.h"

namespace ensonify {

// A constant amplitude without a random part is one; NaN and infinity are not.
inline bool is_an_echo(const ScattererMoments& moments) {
  return std::isfinite(moments.mean_m) && std::isfinite(moments.variance_m2) &&
         moments.variance_m2 >= 0 && (moments.mean_m > 0 || moments.variance_m2 > 0);
}

// Beyond every ray's key; a target is not drawn, its key only settles ties.
inline std::uint64_t point_target_key(std::uint32_t instance) {
  return std::uint64_t{1} << 63 | instance;
}
inline std::uint64_t fish_key(std::uint32_t school, std::size_t fish) {
  return point_target_key(school) | std::uint64_t{fish + 1} << 32;
}

inline bool is_usable(const Hit& hit, const Sonar& sonar) {
  return hit.instance != 0 && in_range(hit.range_m, sonar) && hit.cos_incidence >= 0 &&
         hit.cos_incidence <= 1;
}

// The directions of a fan from what its rows and columns share.
struct FanDirections {
  struct Part {
    double angle_rad = 0, cosine = 1, sine = 0, pattern = 1;
  };
  std::vector<Part> elevation, azimuth;

  EchoDirection at(std::size_t column, std::size_t e) const {
    const Part &up = elevation[e], &along = azimuth[column];
    return {along.angle_rad,
            up.angle_rad,
            {up.cosine * along.cosine, up.cosine * along.sine, up.sine},
            up.pattern,
            along.pattern};
  }
};

inline FanDirections directions_of(const Fan& fan, const Sonar& sonar) {
  FanDirections directions;
  for (const double x : fan.elevation_rad) {
    directions.elevation.push_back(
        {x, std::cos(x), std::sin(x), echo_direction(0, x, sonar).elevation_pattern});
  }
  for (const double x : fan.azimuth_rad) {
    directions.azimuth.push_back(
        {x, std::cos(x), std::sin(x), echo_direction(x, 0, sonar).transmit_pattern});
  }
  return directions;
}

// The scatterers of rays, one by one, into what is all zero before.
struct SurfaceEchoes {
  const Fan& fan;
  const SurfaceScattering& scattering;
  FanDirections directions = directions_of(fan, scattering.sonar);

  // False for a hit that is none. `path`: of a bent ray.
  bool moments(const Hit& hit, std::size_t e, ScattererMoments& moments,
               const RayPath* path = nullptr) const {
    if (!is_usable(hit, scattering.sonar)) return false;
    ENSONIFY_ASSERT(hit.instance < scattering.material.size());
    moments = scatterer_moments(material_at(scattering, hit), hit.reflectivity, hit.cos_incidence,
                                path == nullptr ? hit.range_m : std::sqrt(path->tube_area_m2),
                                fan.solid_angle_sr[e]);
    return is_an_echo(moments);
  }

  // `i` counts the rays of a sector; `hit` is on ray i of the beam.
  void set(std::uint32_t beam, std::uint32_t i, const Hit& hit, const ScattererMoments& moments,
           Scatterer& s, const RayPath* path = nullptr) const {
    const auto rows = static_cast<std::uint32_t>(fan.rays_elevation);
    const EchoDirection direction =
        directions.at(std::size_t(beam) * fan.rays_azimuth + i / rows, i % rows);
    set_echo(hit.range_m, direction, beam, scattering.water, s);
    if (path != nullptr) set_bent(*path, direction, scattering.water, s);
    s.standard_deviation = static_cast<float>(std::sqrt(moments.variance_m2));
    s.mean = static_cast<float>(moments.mean_m);
    s.cos_incidence = hit.cos_incidence;
    s.key = beam * fan.rays_per_beam() + i;
    s.instance = hit.instance;
  }
};

}  // namespace ensonify
