// Rays against the world: first hits, in double precision, and what is behind them.
//
//   Fan         make_fan  ray_index   every sector cut into cells of azimuth and elevation, a ray
//               through the middle of each
//   Tracer      at first_hit first_hits trace_fan hits_along trace_behind
//   Hit         what one ray found
//   HitsBehind  what the rays of a fan would find farther on
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
  std::vector<double> solid_angle_sr;  // [rays_elevation], exact, the same for every azimuth

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
  float reflectivity = 1;      // factor of the mesh's own on the material's
  std::uint16_t part = 0;      // 0: of the object's own material; k: WorldObject::parts
  Vec3 normal{};               // unit length, of either sign, in the world
};

// The most surfaces along one ray that are told: the nearest.
inline constexpr int kMostLayers = 8;

// A point is hidden by what stands in front of it, not by the surface that it lies on: part of its
// range.
inline constexpr double kOnSurface = 1e-6;

// Where each ray would first meet each other instance, were all that it meets before transparent.
struct HitsBehind {
  std::vector<std::uint32_t> offset;  // [rays + 1]
  std::vector<Hit> hits;              // of ray i [offset[i], offset[i + 1]), nearest first

  std::span<const Hit> of_ray(std::size_t ray) const {
    return std::span(hits).subspan(offset[ray], offset[ray + 1] - offset[ray]);
  }
};

// The world at one moment. A value: copies share what was built, and may be used at once.
class Tracer {
 public:
  // Every object at its own pose. Builds the acceleration structures; `world` must outlive the
  // tracer and all that come from it.
  // Throws DeviceFailure where Embree finds no memory or cannot start.
  explicit Tracer(const World& world);

  // The same world with each object at another pose (in the world, in the order of
  // World::objects). Builds what holds the objects, never a mesh again; nothing where no pose is
  // another.
  Tracer at(std::span<const Pose> object_in_world) const;

  // The nearest surface within (0, range_max_m]. Embree finds which surface it is, in float; range
  // and incidence are worked out again in double.
  Hit first_hit(const Ray& ray, double range_max_m) const;

  // The same for many rays from one place, in packets: neighbours should have about the same
  // direction.
  void first_hits(Vec3 origin_m, std::span<const Vec3> directions, double range_max_m,
                  std::span<Hit> hits) const;

  // One hit a ray, in the order of ray_index; pose is the sonar's in the world.
  std::vector<Hit> trace_fan(const Fan& fan, const Pose& pose, double range_max_m,
                             const Workers& workers) const;

  // The first hit of every instance along a ray, nearest first (of equal ranges the lower id): the
  // nearest kMostLayers within (0, range_max_m]. Ranges are those of first_hit.
  std::vector<Hit> hits_along(const Ray& ray, double range_max_m) const;

  // Continues the rays of a fan that met something, `hits` as trace_fan gave them: the other
  // instances along each, as hits_along has them, at most kMostLayers - 1. A ray's own instance is
  // transparent as a whole, its far side too. The same for any workers.
  HitsBehind trace_behind(const Fan& fan, std::span<const Hit> hits, const Pose& pose,
                          double range_max_m, const Workers& workers) const;

  // The instruction set that Embree runs on here ("avx512", "avx2", "sse"): hits at edges may
  // differ between them.
  std::string instruction_set() const;

 private:
  struct Impl;
  explicit Tracer(std::shared_ptr<const Impl> impl);

  std::shared_ptr<const Impl> impl_;
};

}  // namespace ensonify
