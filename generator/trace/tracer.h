// Rays traced against the world: first hits, in double precision, and the hits behind them.
//
//   Fan         make_fan  ray_index   every beam cell cut into cells of azimuth and elevation, with
//               a ray through the middle of each
//   Tracer      at first_hit first_hits trace_fan hits_along trace_behind
//   Hit         the result of one ray
//   HitsBehind  hits of the rays of a fan behind the first ones
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "core/sonar.h"
#include "world/world.h"

namespace ensonify {

struct Fan {
  int beams = 0, rays_azimuth = 0, rays_elevation = 0;
  std::vector<double> azimuth_rad;     // [beams x rays_azimuth], middles of the cells
  std::vector<double> elevation_rad;   // [rays_elevation], lowest first
  std::vector<double> solid_angle_sr;  // [rays_elevation], exact, of a beam cell of mean width
  // [beams]: width of the beam cell as a share of the mean. Empty: all are equally wide.
  std::vector<double> relative_width = {};

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

Fan make_fan(const Sonar& sonar);

inline std::size_t ray_index(const Fan& fan, int beam, int azimuth, int elevation) {
  return (std::size_t(beam) * fan.rays_azimuth + azimuth) * fan.rays_elevation + elevation;
}

struct Hit {
  double range_m = 0;
  float cos_incidence = 0;     // |ray . normal|
  std::uint32_t instance = 0;  // 0: the ray missed
  float reflectivity = 1;      // factor of the mesh on the material's
  std::uint16_t part = 0;      // 0: the object's own material; k: WorldObject::parts
  std::uint16_t own_part = 0;  // without growth: the part that the mesh gives
  Vec3 normal{};               // unit length, of either sign, in the world
};

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

// The world at one moment. Copies share the acceleration structures and may be used concurrently.
class Tracer {
 public:
  // Every object at its own pose. Builds the acceleration structures; `world` must outlive the
  // tracer and all tracers made from it. Throws DeviceFailure if Embree runs out of memory or
  // cannot start.
  explicit Tracer(const World& world);

  // The same world with other poses of the objects (in the world, in the order of World::objects).
  // Rebuilds the scene of the objects but not the meshes, and builds nothing if all poses are
  // unchanged.
  Tracer at(std::span<const Pose> object_in_world) const;

  // The nearest surface within (0, range_max_m]. Embree finds the surface, in float; range and
  // incidence are then computed in double precision.
  Hit first_hit(const Ray& ray, double range_max_m) const;

  // The same for many rays from one point, in packets: neighbors should have similar directions.
  void first_hits(Vec3 origin_m, std::span<const Vec3> directions, double range_max_m,
                  std::span<Hit> hits) const;

  // One hit per ray, in the order of ray_index; `pose` is the sonar's in the world.
  std::vector<Hit> trace_fan(const Fan& fan, const Pose& pose, double range_max_m,
                             const Workers& workers) const;

  // The first hit of every instance along a ray, nearest first (at equal ranges the lower id
  // first): the nearest kMostLayers within (0, range_max_m]. Ranges are those of first_hit.
  std::vector<Hit> hits_along(const Ray& ray, double range_max_m) const;

  // Continues the rays of a fan that met something; `hits` are those of trace_fan. Finds at most
  // kMostLayers - 1 other instances along each ray, as hits_along does. The instance of the first
  // hit is transparent as a whole, including its far side. The result does not depend on the
  // workers.
  HitsBehind trace_behind(const Fan& fan, std::span<const Hit> hits, const Pose& pose,
                          double range_max_m, const Workers& workers) const;

  // The instruction set that Embree uses here ("avx512", "avx2", "sse"): hits at edges may differ
  // between them.
  std::string instruction_set() const;

 private:
  struct Impl;
  explicit Tracer(std::shared_ptr<const Impl> impl);

  std::shared_ptr<const Impl> impl_;
};

}  // namespace ensonify
