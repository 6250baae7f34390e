// Rays in water whose sound speed changes with depth, against the world.
//
//   RayPath  FanHits  FanHitsBehind   what rays meet, and the path there
//   trace_fan  trace_behind           straight, or refracted where the water bends rays
//   RefractedRays                          rays of one moment, one by one
//   RefractedHit  first_refracted_hit  refracted_hits_along
//
// A refracted ray is followed as chords that leave it by a tenth of a millimetre at most; what a
// chord meets is put where the ray itself crosses the plane that touches the surface there. So the
// travel time is that of the closed forms on whatever is plane, and off by that distance squared
// over the surface's radius elsewhere.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "acoustics/refraction.h"
#include "core/parallel.h"
#include "core/sonar.h"
#include "trace/tracer.h"

namespace ensonify {

// Beside a Hit, whose range_m is then the one that the instrument shows: its sound speed times the
// travel time one way.
struct RayPath {
  Vec3 position_m;                // where it ends, in the sonar frame
  double length_m = 0;            // along the ray
  double tube_area_m2 = 0;        // A / dOmega
  double spreading_m2 = 0;        // two_way_spreading_m2
  double curvature_radius_m = 0;  // of the wave that comes back, sideways
};

// In the order of ray_index. `paths` is empty where rays are straight, else as long as `hits`.
struct FanHits {
  std::vector<Hit> hits;
  std::vector<RayPath> paths;
};
struct FanHitsBehind {
  HitsBehind behind;
  std::vector<RayPath> paths;
};

// Tracer's where !bends(water); else each ray along its refracted path, as far as the record is
// long. The same for any workers.
FanHits trace_fan(const Tracer& tracer, const Fan& fan, const Pose& sonar_in_world,
                  const Sonar& sonar, const Water& water, const Workers& workers);
FanHitsBehind trace_behind(const Tracer& tracer, const Fan& fan, std::span<const Hit> hits,
                           const Pose& sonar_in_world, const Sonar& sonar, const Water& water,
                           const Workers& workers);

struct RefractedRays {
  const Tracer& tracer;
  SoundLayers layers;
  Pose sonar_in_world;
  double instrument_speed_m_s = 0;
  double frequency_hz = 0;
};

// Needs bends(water).
RefractedRays refracted_rays(const Tracer& tracer, const Pose& sonar_in_world, const Sonar& sonar,
                             const Water& water);

// The path to a point of a ray that starts in `direction`, of unit length in the world.
RayPath path_to(const RefractedRays& rays, Vec3 direction, const RayPoint& point);

struct RefractedHit {
  Hit hit;
  RayPath path;
};

// What a ray from the sonar meets first within time_max_s, one way.
std::optional<RefractedHit> first_refracted_hit(const RefractedRays& rays, Vec3 direction,
                                                double time_max_s);

// The first hit of every instance but `skip`, nearest first, the nearest `most`.
std::vector<RefractedHit> refracted_hits_along(const RefractedRays& rays, Vec3 direction,
                                               double time_max_s, std::uint32_t skip = 0,
                                               int most = kMostLayers);

}  // namespace ensonify
