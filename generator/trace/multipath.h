// Echoes over mirrors: what sound does between the sonar and what throws it back.
//
//   BouncedMoment  bounced_echoes
//   both_ways_as_one
//   LegEnd    one end of a path: a point, seen over a leg
//   Bounces   make_bounces   straight trace reach is_free   of one ping
//   echo_of   from two ends to a scatterer
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
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
// A path is heard where every mirror is met within its bounds, nothing stands in any of its pieces,
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

struct LegEnd {
  std::uint16_t leg = 0;
  Vec3 point_m;    // from the sonar, turned as the world is
  Vec3 direction;  // in which sound from the sonar comes to the point
  Walk way;
  double length_m = 0, reflection = 1;
  double azimuth_rad = 0, elevation_rad = 0;  // at the sonar, in its frame
  std::uint32_t beam = 0;
  double cos_incidence = 0;
  std::optional<double> extinction_db;  // of volumes, this way alone
};

struct Bounces {
  const BouncePlan& plan;
  const Tracer& tracer;
  const std::vector<Volume>& volumes;
  const SurfaceScattering& scattering;
  Pose pose;
  std::vector<PlacedMirror> mirrors;
  std::vector<bool> possible;  // by leg: whether the sonar's images are before the next mirrors
  double wavelength_m = 0;
  double length_max_m = 0;  // of one leg, the other being ever so short
  bool volumes_attenuate = false;

  bool is_possible(std::uint16_t leg) const { return possible[leg]; }
  // Not above the surface.
  bool is_in_water(Vec3 point_m) const;
  Vec3 to_sonar(Vec3 point_m) const { return rotate(conjugate(pose.rotation), point_m); }

  // What a direct ray met.
  LegEnd straight(Vec3 sonar_direction, double range_m) const;
  // What a ray meets over a leg, and the hit; the angles are the caller's.
  std::optional<LegEnd> trace(std::uint16_t leg, Vec3 sonar_direction, Hit& hit) const;
  // By geometry alone; none outside the fan, or where the path there and back, `other_m` being the
  // length of the other leg, is too long.
  std::optional<LegEnd> reach(std::uint16_t leg, Vec3 point_m, double other_m) const;
  // Whether nothing stands in the way.
  bool is_free(const LegEnd& end) const;
  // Once; nothing where no volume attenuates.
  void add_extinction(LegEnd& end) const;

 private:
  bool stays_in_water(const Leg& leg, const Walk& way) const;
  bool mirrors_are_met(const Leg& leg, const Walk& way) const;
};

Bounces make_bounces(const BouncedMoment& moment);

// Delay, directions, sector, gain, incidence and received length; none out of range, or where
// nothing is left.
std::optional<Scatterer> echo_of(const LegEnd& out, const LegEnd& back, const Sonar& sonar,
                                 const Water& water);

}  // namespace ensonify
