// Rays in water whose sound speed changes with depth, traced against the world.
//
//   RayPath  FanHits  FanHitsBehind   hits of rays, and the paths to them
//   trace_fan  trace_behind           straight, or refracted if the sound speed varies
//   RefractedRays                     rays at one moment, one by one
//   RefractedHit  first_refracted_hit  refracted_hits_along
//
// A refracted ray is followed as chords within a tenth of a millimeter of it. The hit of a chord is
// moved to where the ray itself crosses the tangent plane of the surface there. Therefore the
// travel time to a plane agrees with the closed forms. On other surfaces its error is the square of
// that distance divided by the radius of the surface.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "acoustics/refraction.h"
#include "core/parallel.h"
#include "core/sonar.h"
#include "trace/tracer.h"

namespace ensonify {

// Belongs to a Hit, whose range_m is then the range that the instrument shows: its sound speed
// times the one-way travel time.
struct RayPath {
  Vec3 position_m;                // end of the path, sonar frame
  double length_m = 0;            // along the ray
  double tube_area_m2 = 0;        // A / dOmega
  double spreading_m2 = 0;        // two_way_spreading_m2
  double curvature_radius_m = 0;  // of the returning wave, horizontally
};

// In the order of ray_index. `paths` is empty for straight rays; otherwise it is as long as `hits`.
struct FanHits {
  std::vector<Hit> hits;
  std::vector<RayPath> paths;
};
struct FanHitsBehind {
  HitsBehind behind;
  std::vector<RayPath> paths;
};

// Tracer's functions if !bends(water); otherwise each ray follows its refracted path for the length
// of the record. The result does not depend on the workers.
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

// The first hit of a ray from the sonar within a one-way travel time of time_max_s.
std::optional<RefractedHit> first_refracted_hit(const RefractedRays& rays, Vec3 direction,
                                                double time_max_s);

// The first hit of every instance except `skip`, nearest first, at most `most`.
std::vector<RefractedHit> refracted_hits_along(const RefractedRays& rays, Vec3 direction,
                                               double time_max_s, std::uint32_t skip = 0,
                                               int most = kMostLayers);

}  // namespace ensonify
