// One end of a path: how a point is reached over a leg. Private to the bounced echoes.
//
//   LegEnd    a point, seen over a leg
//   Bounces   make_bounces   straight trace reach is_free   of one ping
//   echo_of   from two ends to a scatterer
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/scatterers.h"
#include "trace/mirrors.h"
#include "trace/multipath.h"

namespace ensonify {

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
  // By geometry alone; none outside the fan, or where the way there and back, `other_m` being the
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
