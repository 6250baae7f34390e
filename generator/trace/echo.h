// From one hit or position to its scatterer, and keys. Private to trace/.
//
//   in_range  is_usable  is_an_echo
//   EchoDirection  echo_direction   what depends on the direction alone
//   set_echo  set_refracted  echo_from  echo_at
//   point_target_key  add_tap  fish_key
//   elevation_step_rad  azimuth_step_rad
//   FanDirections  elevation_part  directions_of
//   surface_moments  set_surface_echo  SurfaceEchoes   the scatterers of a fan's rays
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "acoustics/scattering.h"
#include "core/elastic.h"
#include "core/error.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "trace/refracted.h"
#include "trace/surface_scattering.h"

namespace ensonify {

// Whether a range is finite, above zero and within [range_min, range_max].
inline bool in_range(double range_m, const Sonar& sonar) {
  return std::isfinite(range_m) && range_m > 0 && range_m >= sonar.range_min_m &&
         range_m <= sonar.range_max_m;
}

// What depends on the direction of an echo alone, computed once if many echoes share it.
struct EchoDirection {
  double azimuth_rad = 0, elevation_rad = 0;
  Vec3 unit;
  double elevation_pattern = 1, transmit_pattern = 1;
};
inline EchoDirection echo_direction(double azimuth_rad, double elevation_rad, const Sonar& sonar) {
  return {azimuth_rad, elevation_rad, unit_vector(azimuth_rad, elevation_rad),
          elevation_pattern(sonar, elevation_rad),
          transmit_pattern(azimuth_rad, sonar.transmit_width_rad)};
}

// Sets delay 2r/c, position, directions, beam, received path, and the gain
// r^-2 10^(-absorption 2r/20) B_el(elevation) B_tx(azimuth). The caller sets amplitude, instance
// and key.
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

// Sets what differs for a refracted path: position, gain, and the curvature of the returning wave.
inline void set_refracted(const RayPath& path, const EchoDirection& direction, const Water& water,
                          Scatterer& s) {
  constexpr double kLn10 = 2.302585092994045684;
  s.position_m = path.position_m;
  s.gain = static_cast<float>(std::exp(-water.absorption_db_m * path.length_m * (kLn10 / 10.0)) /
                              path.spreading_m2 * direction.elevation_pattern *
                              direction.transmit_pattern);
  s.received_path_m = static_cast<float>(path.curvature_radius_m);
}

inline Scatterer echo_from(double range_m, double azimuth_rad, double elevation_rad, int beam,
                           const Sonar& sonar, const Water& water) {
  Scatterer s;
  set_echo(range_m, echo_direction(azimuth_rad, elevation_rad, sonar),
           static_cast<std::uint32_t>(beam), water, s);
  return s;
}

// The same from a place in the world, on the straight path; none outside the fan or its ranges.
inline std::optional<Scatterer> echo_at(Vec3 place_m, const Pose& sonar_in_world,
                                        const Sonar& sonar, const Water& water) {
  const Vec3 p = inverse_transform_point(sonar_in_world, place_m);
  const double range = length(p);
  if (!in_range(range, sonar)) return std::nullopt;
  const double azimuth = std::atan2(p.y, p.x);
  const double elevation = std::asin(std::clamp(p.z / range, -1.0, 1.0));
  const std::optional<int> beam = sector_of(sonar, azimuth);
  if (!beam || std::abs(elevation) > sonar.elevation_fan_rad / 2) return std::nullopt;
  return echo_from(range, azimuth, elevation, *beam, sonar, water);
}

// Returns false if the amplitude is zero, NaN or infinite. A constant amplitude needs no random
// part.
inline bool is_an_echo(const ScattererMoments& moments) {
  return std::isfinite(moments.mean_m) && std::isfinite(moments.variance_m2) &&
         moments.variance_m2 >= 0 && (moments.mean_m > 0 || moments.variance_m2 > 0);
}

// Lies above the keys of all rays. A target has no random amplitude; its key only orders equal
// delays.
inline std::uint64_t point_target_key(std::uint32_t instance) {
  return std::uint64_t{1} << 63 | instance;
}
// Adds echo `number` of a target that rings, given that of its center.
inline void add_tap(const Scatterer& center, const Tap& tap, std::size_t number,
                    std::vector<Scatterer>& scatterers) {
  Scatterer& s = scatterers.emplace_back(center);
  s.lag_s = static_cast<float>(tap.delay_s);
  s.delay_s += tap.delay_s;
  s.mean = std::complex<float>(tap.gain);
  s.key |= std::uint64_t{number} << 32;
}
// Of an edge, whose pieces come in the lowest 28 bits: bits 60 and 62. Smooth surfaces have bit 62
// alone and chains of mirrors bits 61 and 62. No amplitude is random.
inline std::uint64_t edge_key(std::uint64_t edge) { return std::uint64_t{5} << 60 | edge << 28; }
// Of a piece of an elastic body, whose taps come in bits 32 and up: bits 60 and 61.
inline std::uint64_t elastic_key(std::uint32_t instance, int piece) {
  return std::uint64_t{3} << 60 | std::uint64_t{instance} << 44 | static_cast<std::uint32_t>(piece);
}
inline std::uint64_t fish_key(std::uint32_t school, std::size_t fish) {
  return point_target_key(school) | std::uint64_t{fish + 1} << 32;
}

inline bool is_usable(const Hit& hit, const Sonar& sonar) {
  return hit.instance != 0 && in_range(hit.range_m, sonar) && hit.cos_incidence >= 0 &&
         hit.cos_incidence <= 1;
}

// Angles between adjacent rays of a fan.
inline double elevation_step_rad(const Sonar& sonar) {
  return sonar.elevation_fan_rad / sonar.rays_elevation;
}
inline double azimuth_step_rad(const Sonar& sonar) {
  return sonar.beam_spacing_rad / sonar.rays_azimuth;
}

// The directions of a fan, from the values that its rows and columns share.
struct FanDirections {
  struct Part {
    double angle_rad = 0, cosine = 1, sine = 0, pattern = 1;
  };
  std::vector<Part> elevation, azimuth;

  static EchoDirection of(const Part& along, const Part& up) {
    return {along.angle_rad,
            up.angle_rad,
            {up.cosine * along.cosine, up.cosine * along.sine, up.sine},
            up.pattern,
            along.pattern};
  }
  EchoDirection at(std::size_t column, std::size_t e) const {
    return of(azimuth[column], elevation[e]);
  }
};

inline FanDirections::Part elevation_part(double angle_rad, const Sonar& sonar) {
  return {angle_rad, std::cos(angle_rad), std::sin(angle_rad), elevation_pattern(sonar, angle_rad)};
}

inline FanDirections directions_of(const Fan& fan, const Sonar& sonar) {
  FanDirections directions;
  for (const double x : fan.elevation_rad) {
    directions.elevation.push_back(elevation_part(x, sonar));
  }
  for (const double x : fan.azimuth_rad) {
    directions.azimuth.push_back(
        {x, std::cos(x), std::sin(x), transmit_pattern(x, sonar.transmit_width_rad)});
  }
  return directions;
}

// Computes the moments of the scatterer at a hit; returns false if the hit gives no echo. `path` is
// that of a refracted ray, and null for a straight ray.
inline bool surface_moments(const SurfaceScattering& scattering, const Hit& hit,
                            double solid_angle_sr, const RayPath* path, ScattererMoments& moments) {
  if (!is_usable(hit, scattering.sonar)) return false;
  ENSONIFY_ASSERT(hit.instance < scattering.material.size());
  moments = scatterer_moments(material_at(scattering, hit), hit.reflectivity, hit.cos_incidence,
                              path == nullptr ? hit.range_m : std::sqrt(path->tube_area_m2),
                              solid_angle_sr);
  return is_an_echo(moments);
}

// Writes the scatterer at a hit into `s`, whose members must all be zero.
inline void set_surface_echo(const SurfaceScattering& scattering, const EchoDirection& direction,
                             std::uint32_t beam, std::uint64_t key, const Hit& hit,
                             const ScattererMoments& moments, const RayPath* path, Scatterer& s) {
  set_echo(hit.range_m, direction, beam, scattering.water, s);
  if (path != nullptr) set_refracted(*path, direction, scattering.water, s);
  s.standard_deviation = static_cast<float>(std::sqrt(moments.variance_m2));
  s.mean = static_cast<float>(moments.mean_m);
  s.cos_incidence = hit.cos_incidence;
  s.key = key;
  s.instance = hit.instance;
}

// The scatterers of the rays of a fan.
struct SurfaceEchoes {
  const Fan& fan;
  const SurfaceScattering& scattering;
  FanDirections directions = directions_of(fan, scattering.sonar);

  bool moments(const Hit& hit, std::size_t beam, std::size_t e, ScattererMoments& moments,
               const RayPath* path = nullptr) const {
    return surface_moments(scattering, hit, fan.cell_sr(beam, e), path, moments);
  }

  // `i` counts the rays of a beam cell; `hit` is that of ray i.
  void set(std::uint32_t beam, std::uint32_t i, const Hit& hit, const ScattererMoments& moments,
           Scatterer& s, const RayPath* path = nullptr) const {
    const auto rows = static_cast<std::uint32_t>(fan.rays_elevation);
    set_surface_echo(scattering,
                     directions.at(std::size_t(beam) * fan.rays_azimuth + i / rows, i % rows), beam,
                     beam * fan.rays_per_beam() + i, hit, moments, path, s);
  }
};

}  // namespace ensonify
