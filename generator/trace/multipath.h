// Multipath: echoes over flat specular reflectors between the sonar and a scatterer.
//
//   BouncedMoment  bounced_echoes
//   both_ways_as_one
//   LegEnd   set_direction   one end of a path: a point at the end of a leg
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

// The scatterers of all paths of the plan except the direct one, in an order that does not depend
// on the workers. `hits`: the direct rays of the fan, from trace_fan.
//
// The fan is traced over every leg with at most half the bounces. Both directions of a path give an
// echo, for the surface element that a ray meets and for every later leg over which the element is
// also seen. If the legs are the same, they give one echo. An element has the area r^2 dOmega / cos
// of its ray, where r is the unfolded length, and scatters by bistatic_moments. Point targets and
// fish are tested over all legs.
//
// A path gives an echo if every reflector is met within its bounds, nothing blocks any of its
// pieces, no point of it is above the surface (nor below the bottom, if it reflects off that), both
// its directions at the sonar are inside the fan, and c delay/2 is within the ranges. Its gain is
// path_loss times all reflection coefficients, the elevation pattern of both directions, the
// transmit pattern of the departure, and the extinction by volumes on all pieces.
//
// Both directions share amplitude and key: the pair's lower path id times 2^40, plus the ray over
// the first leg. A target keeps the key of its direct echo.
std::vector<Scatterer> bounced_echoes(const BouncedMoment& moment, const Fan& fan,
                                      std::span<const Hit> hits, const Workers& workers);

// Merges the two directions of a pair that arrive in one beam cell into one echo with the first
// one's path and the sum of their gains. They have the same delay and amplitude and add in phase,
// which a sum of energies would miss. This is for receivers that form beams from beam cells, which
// cannot distinguish the two. `echoes` as returned by bounced_echoes.
std::vector<Scatterer> both_ways_as_one(std::vector<Scatterer> echoes);

struct LegEnd {
  std::uint16_t leg = 0;
  Vec3 point_m;    // relative to the sonar, along the axes of the world
  Vec3 direction;  // of the sound that arrives at the point
  Walk way;
  double length_m = 0, reflection = 1;
  double azimuth_rad = 0, elevation_rad = 0;  // at the sonar, in its frame
  std::uint32_t beam = 0;
  double cos_incidence = 0;
  std::optional<double> extinction_db;  // by volumes, on this leg alone
};

// Sets elevation, azimuth and beam for a point seen from the sonar, in its frame, at the length of
// the end. False if it is outside the fan.
bool set_direction(const Sonar& sonar, Vec3 seen_m, LegEnd& end);

struct Bounces {
  const BouncePlan& plan;
  const Tracer& tracer;
  const std::vector<Volume>& volumes;
  const SurfaceScattering& scattering;
  Pose pose;
  std::vector<PlacedMirror> mirrors;
  std::vector<bool> possible;  // by leg: whether the sonar's images face the reflectors
  double wavelength_m = 0;
  double length_max_m = 0;  // of one leg, if the other one has length 0
  bool volumes_attenuate = false;

  bool is_possible(std::uint16_t leg) const { return possible[leg]; }
  // Not above the surface.
  bool is_in_water(Vec3 point_m) const;
  Vec3 to_sonar(Vec3 point_m) const { return rotate(conjugate(pose.rotation), point_m); }

  // The end of a direct ray.
  LegEnd straight(Vec3 sonar_direction, double range_m) const;
  // The end of a ray over a leg, and its hit; the caller sets the angles. Returns none if the ray
  // cannot follow the leg or meets nothing.
  std::optional<LegEnd> trace(std::uint16_t leg, Vec3 sonar_direction, Hit& hit) const;
  // The end at a given point, by geometry alone. Returns none if the point does not appear inside
  // the fan over this leg, or if the path is too long together with `other_m`, the length of the
  // other leg.
  std::optional<LegEnd> reach(std::uint16_t leg, Vec3 point_m, double other_m) const;
  // Whether nothing blocks the leg.
  bool is_free(const LegEnd& end) const;
  // Computes the extinction once; does nothing if no volume attenuates.
  void add_extinction(LegEnd& end) const;

 private:
  bool stays_in_water(const Leg& leg, const Walk& way) const;
  bool mirrors_are_met(const Leg& leg, const Walk& way) const;
};

Bounces make_bounces(const BouncedMoment& moment);

// Sets delay, directions, beam, gain, incidence and received path. None if out of range or if the
// gain is 0.
std::optional<Scatterer> echo_of(const LegEnd& out, const LegEnd& back, const Sonar& sonar,
                                 const Water& water);

}  // namespace ensonify
