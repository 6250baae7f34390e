// Paths that only mirrors shape: rays followed from smooth surface to smooth surface. Private to trace/.
//
//   MirrorWalk  follow_mirrors    where a ray goes
//   spreading_per_m2              of the tube about it
//   Connection  connect           the last piece of a path, straight back to the sonar
//   chain_scatterers              the coherent echoes of chains of mirrors
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "trace/bounces.h"

namespace ensonify {

inline constexpr int kMostSurfaces = kMostBounces + 1;

// Where a path meets a surface. Places are seen from the sonar, turned as the world is.
struct WalkStep {
  Vec3 point_m, direction;  // in which sound comes
  Vec3 normal;              // on the side that sound comes from
  Hit hit;
  double length_m = 0;       // from the sonar to here, unfolded
  double reflection = 0;     // R of the surface, 0 where it is no mirror
  double extinction_db = 0;  // of volumes, up to here
};

struct MirrorWalk {
  int steps = 0, mirrors = 0;  // all surfaces met; those in front that are mirrors
  std::array<WalkStep, kMostSurfaces> step;
};

// What a sequence and a ping fix, worked out once.
struct BounceContext {
  const BouncePing& ping;
  double wavelength_m = 0, length_max_m = 0, extinction_step_m = 0;
  bool volumes_attenuate = false;

  Vec3 to_sonar(Vec3 v) const { return rotate(conjugate(ping.sonar_in_world.rotation), v); }
  const Material& material(const Hit& hit) const { return material_at(ping.scattering, hit); }
  double piece_extinction_db(Vec3 from_m, Vec3 direction, double piece_m) const;
  // The next surface from a step in a direction; none where nothing is met in reach.
  std::optional<WalkStep> next(const WalkStep& from, Vec3 direction) const;
};

BounceContext bounce_context(const BouncePing& ping);

// Where the sonar's direct ray met something.
WalkStep first_step(const BounceContext& context, Vec3 world_direction, const Hit& hit);

// From a first surface on, up to `most` surfaces, the last of which need not be a mirror.
MirrorWalk follow_mirrors(const BounceContext& context, const WalkStep& first, int most);

// J = dOmega / dA of the ray tube about a ray of the fan at surface `surface` of its walk, by two rays
// beside it; 1/r^2 of the unfolded length where these go another way. At most 1/(lambda d), d the last
// piece.
double spreading_per_m2(const BounceContext& context, double azimuth_rad, double elevation_rad,
                        const MirrorWalk& walk, int surface);

struct Connection {
  Vec3 direction;  // from the surface to the sonar
  double length_m = 0, azimuth_rad = 0, elevation_rad = 0;
  double cosine = 0;  // to the surface's normal
  double extinction_db = 0;
  std::uint32_t beam = 0;
};

// None outside the fan, from behind the surface, or where something stands between.
std::optional<Connection> connect(const BounceContext& context, const WalkStep& from);

// Echoes over two to bounces + 1 mirrors and nothing else. `walks`: of every ray of the fan.
std::vector<Scatterer> chain_scatterers(const BounceContext& context, const Fan& fan,
                                        std::span<const MirrorWalk> walks, const Workers& workers);

}  // namespace ensonify
