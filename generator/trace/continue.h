// Rays that go on behind what they meet.
//
// Every object is one primitive of a scene of its own, whose callback takes down where a ray first
// meets the object and lets the ray go on, as if it had missed. So one pass finds the first hit of
// every instance along a ray, in any order, without starting anew behind a hit; and an object that
// is met first is asked no second time.
//
//   AlongScene  build_along_scene
//   Layers      what one ray meets
//   hits_along  trace_behind   Tracer's
#pragma once

#include <array>
#include <vector>

#include "core/parallel.h"
#include "trace/fan.h"
#include "trace/scene.h"
#include "trace/tracer.h"

namespace ensonify {

struct AlongScene {
  const Scene* scene = nullptr;
  RTCScene top = nullptr;  // primitive k is the scene's by_geometry[k]
  int rays = 4;            // of a packet

  AlongScene() = default;
  ~AlongScene();
  AlongScene(const AlongScene&) = delete;
  AlongScene& operator=(const AlongScene&) = delete;
};

// `scene` must outlive what is built. Throws as the constructor of Tracer.
void build_along_scene(const Scene& scene, AlongScene& along);

// The nearest hits along one ray, one an instance, by range, then id.
struct Layers {
  std::uint32_t skip = 0;  // the instance that is transparent; 0: none
  int most = kMostLayers;
  double range_max_m = 0;
  int count = 0;
  std::array<Hit, kMostLayers> hits;
};

std::vector<Hit> hits_along(const AlongScene& along, const Ray& ray, double range_max_m);

HitsBehind trace_behind(const AlongScene& along, const Fan& fan, std::span<const Hit> hits,
                        const Pose& pose, double range_max_m, const Workers& workers);

}  // namespace ensonify
