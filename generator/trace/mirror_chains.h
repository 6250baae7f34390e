// Paths over specular reflectors of any shape: rays followed from one smooth surface to the next,
// and straight through walls. Private to trace/.
//
//   MirrorWalk  each_walk  follow_turns   the surfaces that a ray meets
//   spreading_per_m2              of the ray tube around it
//   connect                       the last piece of a path, straight back to the sonar
//   ComesBack  comes_back         over which chains of reflectors a ray returns
//   chain_scatterers              the coherent echoes of chains of reflectors
#pragma once

#include <array>
#include <bit>
#include <bitset>
#include <optional>
#include <span>
#include <vector>

#include "trace/bounce_ping.h"
#include "trace/multipath.h"
#include "trace/walls.h"

namespace ensonify {

inline constexpr int kMostSurfaces = kMostBounces + 1;
// Most walls that a walk passes on its way out, and most surfaces and walls that it meets in all.
inline constexpr int kMostPassesOut = 2;
inline constexpr int kMostSteps = kMostSurfaces + kMostPassesOut;

// A point where a path meets a surface. Positions are relative to the sonar, along the axes of the
// world.
struct WalkStep {
  Vec3 point_m, direction;  // of the incoming sound
  Vec3 normal;              // on the side of the incoming sound
  Hit hit;
  double length_m = 0;       // from the sonar to here, unfolded
  double reflection = 0;     // R of the surface without that of its wall, 0 if not specular
  double extinction_db = 0;  // of volumes, up to here
  const WallResponse* wall = nullptr;  // null: none

  bool lets_through() const { return wall != nullptr && wall->lets_through; }
  WallEvent event(bool reflected) const { return wall_event(wall, hit, reflected); }
};

// All surfaces that a ray meets, and what it does at all but the last: bit i of `turns` is 1 if
// step i reflects it, and 0 if it passes straight through.
struct MirrorWalk {
  int steps = 0;
  unsigned turns = 0;
  std::array<WalkStep, kMostSteps> step;

  const WalkStep& last() const { return step[steps - 1]; }
  bool turned(int i) const { return (turns >> i & 1u) != 0; }
  int reflections() const { return std::popcount(turns); }
  int passes() const { return steps - 1 - reflections(); }
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

// Appends the next surface. False if there is none.
bool walk_on(const BounceContext& context, MirrorWalk& walk, bool reflected);

// Calls visit(walk) at each surface that a ray reaches by specular reflections and through walls,
// over at most `most` surfaces besides the walls that it passes. The last surface need not be
// specular. `walk` has the first surface.
template <class Visit>
void each_walk(const BounceContext& context, MirrorWalk& walk, int most, Visit& visit) {
  visit(walk);
  if (walk.steps == kMostSteps) return;
  const unsigned turns = walk.turns;
  const auto go_on = [&](bool reflected) {
    if (!walk_on(context, walk, reflected)) return;
    each_walk(context, walk, most, visit);
    --walk.steps;
    walk.turns = turns;
  };
  if (walk.last().reflection != 0 && walk.reflections() + 1 < most) go_on(true);
  if (walk.last().lets_through() && walk.passes() < kMostPassesOut) go_on(false);
}

// The walk of a ray with the given turns, over at most `steps` surfaces; shorter if the ray meets
// fewer.
MirrorWalk follow_turns(const BounceContext& context, Vec3 direction, const Hit& first,
                        unsigned turns, int steps);

// J = dOmega / dA of the ray tube around a ray of the fan at surface `surface` of its walk, from
// two neighboring rays. If the neighbors meet other surfaces, J is 1/r^2 with the unfolded length
// r. J is at most 1/(lambda d), where d is the length of the last piece.
double spreading_per_m2(const BounceContext& context, double azimuth_rad, double elevation_rad,
                        const MirrorWalk& walk, int surface);

// The straight path from a surface back to the sonar, as the end of a leg at that surface, with its
// cosine to the normal as cos_incidence. The walls that it passes are added to `walls`. Returns
// none if the path is outside the fan, behind the surface, blocked or too long.
std::optional<LegEnd> connect(const BounceContext& context, const WalkStep& from,
                              WallEvents& walls);

// Bit c is 1 if a ray returns to the sonar over the chain of the code c.
using ComesBack = std::bitset<std::size_t{2} << kMostSteps>;
// The chain of a walk whose last surface reflects it: 2^steps + turns.
inline unsigned chain_code(const MirrorWalk& walk) {
  return (1u << walk.steps) | walk.turns | 1u << (walk.steps - 1);
}
// Whether a walk is a chain that returns. One reflection alone, through no wall, is no chain.
bool comes_back(const BounceContext& context, const MirrorWalk& walk);

// Echoes over those chains of reflectors and walls that the rays of the fan found, without any
// other surface.
std::vector<Scatterer> chain_scatterers(const BounceContext& context, const Fan& fan,
                                        std::span<const ComesBack> found, const Workers& workers);

}  // namespace ensonify
