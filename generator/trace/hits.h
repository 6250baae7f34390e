// The rays of a fan, and what they hit.
//
//   Fan  ray_index  fan_of_group
//               every beam cell cut into cells of azimuth and elevation, with a ray
//               through the middle of each
//   Hit  VertexColor  the result of one ray
//   HitsBehind  hits of the rays of a fan behind the first ones
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/vec.h"

namespace ensonify {

struct Fan {
  int beams = 0, rays_azimuth = 0, rays_elevation = 0;
  std::vector<double> azimuth_rad;     // [beams x rays_azimuth], middles of the cells
  std::vector<double> elevation_rad;   // [rays_elevation], lowest first
  std::vector<double> solid_angle_sr;  // [rays_elevation], exact, of a beam cell of mean width
  // [beams]: width of the beam cell as a share of the mean. Empty: all are equally wide.
  std::vector<double> relative_width = {};
  // Of a group of beams that transmits by itself: cell k is that of beam first_beam + k beam_step.
  int first_beam = 0, beam_step = 1;
  bool is_group = false;

  int beam_of(std::size_t cell) const { return first_beam + static_cast<int>(cell) * beam_step; }
  double relative_width_of(std::size_t beam) const {
    return relative_width.empty() ? 1.0 : relative_width[beam];
  }
  // Solid angle of the cells of row e in a beam cell.
  double cell_sr(std::size_t beam, std::size_t e) const {
    return solid_angle_sr[e] * relative_width_of(beam);
  }
  std::size_t size() const { return azimuth_rad.size() * elevation_rad.size(); }
  std::size_t rays_per_beam() const { return std::size_t(rays_azimuth) * rays_elevation; }
};

inline std::size_t ray_index(const Fan& fan, int beam, int azimuth, int elevation) {
  return (std::size_t(beam) * fan.rays_azimuth + azimuth) * fan.rays_elevation + elevation;
}

// The cells of `count` beams, first, first + step ..., of a fan of all beams.
Fan fan_of_group(const Fan& fan, int first, int step, int count);

struct Hit {
  double range_m = 0;
  float cos_incidence = 0;     // |ray . normal|
  std::uint32_t instance = 0;  // 0: the ray missed
  float reflectivity = 1;      // factor of the mesh on the material's
  std::uint16_t part = 0;      // 0: the object's own material; k: WorldObject::parts
  std::uint16_t own_part = 0;  // without growth: the part that the mesh gives
  Vec3 normal{};               // unit length, of either sign, in the world
};

// Linear red, green and blue of the vertices of a mesh, interpolated; none: that of the material.
using VertexColor = std::optional<std::array<double, 3>>;

// Most surfaces that are kept along one ray, the nearest ones.
inline constexpr int kMostLayers = 8;

// As a share of the range: a surface this near to a point does not hide it, because the point lies
// on the surface.
inline constexpr double kOnSurface = 1e-6;

// The first hit of each ray on each other instance, as if all instances in front were transparent.
struct HitsBehind {
  std::vector<std::uint32_t> offset;  // [rays + 1]
  std::vector<Hit> hits;              // ray i: [offset[i], offset[i + 1]), nearest first

  std::span<const Hit> of_ray(std::size_t ray) const {
    return std::span(hits).subspan(offset[ray], offset[ray + 1] - offset[ray]);
  }
};

}  // namespace ensonify
