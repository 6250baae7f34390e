// Rays traced against the world: first hits, in double precision, and the hits behind them.
//
//   make_fan    every beam cell cut into cells of azimuth and elevation, with a ray through the
//               middle of each; Fan, Hit and HitsBehind are in hits.h
//   Tracer      at first_hit first_hits trace_fan hits_along trace_behind
//   hit_after   the first hit of a piece of a path between surfaces
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "core/sonar.h"
#include "trace/hits.h"
#include "world/world.h"

namespace ensonify {

Fan make_fan(const Sonar& sonar);

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
  // Directions of any length in the frame of a pose, from its position. `colors`: one per hit, if
  // they are wanted.
  void first_hits(const Pose& pose, std::span<const Vec3> directions, double range_max_m,
                  std::span<Hit> hits, std::span<VertexColor> colors = {}) const;

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

// A hit nearer than this to the surface on which a piece starts is that surface itself.
inline constexpr double kOnMirror_m = 1e-4;

// The first hit of a piece. If it starts on a surface, that surface does not count.
inline Hit hit_after(const Tracer& tracer, Vec3 from_m, Vec3 direction, double range_max_m,
                     bool on_surface) {
  Hit hit = tracer.first_hit({from_m, direction}, range_max_m);
  if (!on_surface || hit.instance == 0 || hit.range_m > kOnMirror_m) return hit;
  hit = tracer.first_hit({from_m + kOnMirror_m * direction, direction},
                         std::max(0.0, range_max_m - kOnMirror_m));
  hit.range_m += kOnMirror_m;
  return hit;
}

}  // namespace ensonify
