// Paths over specular reflectors of any shape: rays followed from one smooth surface to the next.
// Private to trace/.
//
//   MirrorWalk  follow_mirrors    the surfaces that a ray meets
//   spreading_per_m2              of the ray tube around it
//   connect                       the last piece of a path, straight back to the sonar
//   ComesBack  what_comes_back    over how many reflectors a ray returns
//   chain_scatterers              the coherent echoes of chains of reflectors
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "trace/bounces.h"
#include "trace/multipath.h"

namespace ensonify {

inline constexpr int kMostSurfaces = kMostBounces + 1;

// A point where a path meets a surface. Positions are relative to the sonar, along the axes of the
// world.
struct WalkStep {
  Vec3 point_m, direction;  // of the incoming sound
  Vec3 normal;              // on the side of the incoming sound
  Hit hit;
  double length_m = 0;       // from the sonar to here, unfolded
  double reflection = 0;     // R of the surface, 0 if not specular
  double extinction_db = 0;  // of volumes, up to here
};

struct MirrorWalk {
  int steps = 0, mirrors = 0;  // all surfaces met; the specular ones at the start
  std::array<WalkStep, kMostSurfaces> step;
};

// What is fixed for a ping, computed once.
struct BounceContext {
  const BouncePing& ping;
  double wavelength_m = 0, length_max_m = 0, extinction_step_m = 0;
  bool volumes_attenuate = false;

  Vec3 to_sonar(Vec3 v) const { return rotate(conjugate(ping.sonar_in_world.rotation), v); }
  // The direction of a ray of the fan in the world.
  Vec3 to_world(double azimuth_rad, double elevation_rad) const {
    return normalized(
        rotate(ping.sonar_in_world.rotation, unit_vector(azimuth_rad, elevation_rad)));
  }
  const Material& material(const Hit& hit) const { return material_at(ping.scattering, hit); }
  double piece_extinction_db(Vec3 from_m, Vec3 direction, double piece_m) const;
  // The step at the hit of a ray from another step, which is WalkStep{} at the sonar.
  WalkStep step(const WalkStep& from, Vec3 direction, const Hit& hit) const;
  // The next surface from a step in a direction; none if no surface is in reach.
  std::optional<WalkStep> next(const WalkStep& from, Vec3 direction) const;
};

BounceContext bounce_context(const BouncePing& ping);

// The direction in which a specular reflector sends the sound on.
inline Vec3 reflected_direction(const WalkStep& at) {
  return at.direction - 2 * dot(at.direction, at.normal) * at.normal;
}

// Follows specular reflections from the hit of a direct ray over at most `most` surfaces, the last
// of which need not be specular.
MirrorWalk follow_mirrors(const BounceContext& context, Vec3 direction, const Hit& first, int most);

// J = dOmega / dA of the ray tube around a ray of the fan at surface `surface` of its walk, from
// two neighboring rays. 1/r^2 with the unfolded length r if these meet other surfaces. At most
// 1/(lambda d), where d is the length of the last piece.
double spreading_per_m2(const BounceContext& context, double azimuth_rad, double elevation_rad,
                        const MirrorWalk& walk, int surface);

// The straight path from a surface back to the sonar, as the end of a leg at that surface, with its
// cosine to the normal as cos_incidence. None if it is outside the fan, behind the surface, blocked
// or too long.
std::optional<LegEnd> connect(const BounceContext& context, const WalkStep& from);

// Bit n is 1 if the ray of a walk returns to the sonar over its first n reflectors, n at least 2.
using ComesBack = std::uint8_t;
ComesBack what_comes_back(const BounceContext& context, const MirrorWalk& walk);

// Echoes over two to bounces + 1 specular reflectors and no other surface. `found`: one for each
// ray of the fan.
std::vector<Scatterer> chain_scatterers(const BounceContext& context, const Fan& fan,
                                        std::span<const ComesBack> found, const Workers& workers);

}  // namespace ensonify
