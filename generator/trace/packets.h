// Packets of rays that Embree traces through its hierarchy together. They serve the first hits of a
// fan, whose packets are tiles of neighboring columns and elevations, and rays that continue behind
// a hit.
//
// For the latter every object is one primitive of a separate scene. Its callback records where a
// ray first meets the object and lets the ray continue as if it had missed. Therefore one pass
// finds the first hit of every instance along a ray, in any order and without a restart behind each
// hit.
//
//   fan_tracer  bundle_tracer  packet_rays
//   AlongScene  build_along_scene
//   hits_along  trace_behind   those of Tracer
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "trace/scene.h"

namespace ensonify {

// Tracer::trace_fan.
using FanTracer = std::vector<Hit>(const Scene& scene, const Fan& fan, const Pose& pose,
                                   double range_max_m, const Workers& workers);

// With packets of 4, 8 or 16 rays.
FanTracer* fan_tracer(int rays);

// Both functions Tracer::first_hits. `rotation`: null if the directions are unit vectors in the
// world. `colors` may be empty.
using BundleTracer = void(const Scene& scene, Vec3 origin_m, const Quat* rotation,
                          std::span<const Vec3> directions, double range_max_m, std::span<Hit> hits,
                          std::span<VertexColor> colors);
BundleTracer* bundle_tracer(int rays);

// How many rays Embree traces at once on this processor.
int packet_rays(const Scene& scene);

struct AlongScene {
  const Scene* scene = nullptr;
  RTCScene top = nullptr;  // primitive k is the scene's by_geometry[k]
  int rays = 4;            // of a packet

  AlongScene() = default;
  ~AlongScene();
  AlongScene(const AlongScene&) = delete;
  AlongScene& operator=(const AlongScene&) = delete;
};

// `scene` must outlive `along`. Throws like the constructor of Tracer.
void build_along_scene(const Scene& scene, AlongScene& along);

std::vector<Hit> hits_along(const AlongScene& along, const Ray& ray, double range_max_m);

HitsBehind trace_behind(const AlongScene& along, const Fan& fan, std::span<const Hit> hits,
                        const Pose& pose, double range_max_m, const Workers& workers);

}  // namespace ensonify
