// Echoes over mirrors: what sound does between the sonar and what throws it back.
//
//   BouncedMoment  bounced_echoes
//   both_ways_as_one
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/fan.h"
#include "trace/mirrors.h"
#include "trace/scatter.h"
#include "trace/tracer.h"
#include "world/world.h"

namespace ensonify {

struct BouncedMoment {
  const BouncePlan& plan;
  const World& world;
  const Tracer& tracer;
  std::span<const Pose> object_in_world;  // of the tracer
  Pose sonar_in_world;
  const SurfaceScattering& scattering;
};

// The scatterers of all paths of the plan but the direct one, in a fixed order, whatever the
// workers. `hits`: the direct rays of the fan, as trace_fan gave them.
//
// For every leg with at most half the bounces the fan is traced over it; for the surface element
// that a ray meets, and every later leg that it is seen over too, both ways round are heard (once
// where the legs are the same). An element has the area r^2 dOmega / cos of its ray, r the unfolded
// length, and throws back by bistatic_moments. Point targets and fish are looked at over all legs.
//
// A way is heard where every mirror is met within its bounds, nothing stands in any of its pieces,
// no point of it is above the surface (nor below the bottom, where it bounces off that), both its
// directions at the sonar are inside the fan, and c delay/2 is within the ranges. Its gain is
// path_loss times all reflections, the elevation pattern of both directions, the transmit pattern
// of the departure, and what volumes take on all pieces.
//
// Both ways round share amplitude and key: pair's lower path 2^40 + ray over the first leg; a
// target's is that of its direct echo.
std::vector<Scatterer> bounced_echoes(const BouncedMoment& moment, const Fan& fan,
                                      std::span<const Hit> hits, const Workers& workers);

// Both ways round of a pair that arrive in one sector as one echo of the first's path, with the sum
// of their gains: they have one delay and one amplitude, and so add in phase, which a sum of
// energies would not know. For a receiver of sectors, to which they are the same. `echoes` as
// bounced_echoes gave them.
std::vector<Scatterer> both_ways_as_one(std::vector<Scatterer> echoes);

}  // namespace ensonify
