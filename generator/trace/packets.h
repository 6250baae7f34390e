// The rays of a fan in packets: tiles of neighbouring columns and elevations that Embree takes
// through its hierarchy together.
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "trace/fan.h"
#include "trace/scene.h"
#include "trace/tracer.h"

namespace ensonify {

// Tracer::trace_fan.
using FanTracer = std::vector<Hit>(const Scene& scene, const Fan& fan, const Pose& pose,
                                   double range_max_m, const Workers& workers);

// With packets of 4, 8 or 16 rays.
FanTracer* fan_tracer(int rays);

// Tracer::first_hits.
using BundleTracer = void(const Scene& scene, Vec3 origin_m, std::span<const Vec3> directions,
                          double range_max_m, std::span<Hit> hits);
BundleTracer* bundle_tracer(int rays);

// As many as this processor takes at once.
int packet_rays(const Scene& scene);

}  // namespace ensonify
