// Echoes over several surfaces of any shape: sound that is reflected or scattered more than once.
//
//   BouncePing          what one ping fixes
//   path_of_kinds  bounce_paths   the ids that tell such paths apart
//   bounced_off_surfaces
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/scatter.h"
#include "trace/tracer.h"
#include "world/world.h"

namespace ensonify {

struct BouncePing {
  const Tracer& tracer;
  const std::vector<Volume>& volumes;
  Pose sonar_in_world;
  const SurfaceScattering& scattering;
  int bounces = 0;  // surfaces beyond the first one, at most kMostBounces
  // Both ways round a path that arrive in one sector become one echo with the sum of their gains, as
  // both_ways_as_one has it.
  bool ways_as_one = true;
  std::uint64_t key = 0;  // of Stream::bounces
  std::uint32_t ping = 0;
};

// A path over k surfaces has the id 2^k + kinds: bit i of `kinds` is set where surface i, in the order
// of the sound, reflects as a mirror does; where it scatters, it is not.
constexpr std::uint16_t path_of_kinds(int surfaces, unsigned kinds) {
  return static_cast<std::uint16_t>((1u << surfaces) | kinds);
}

// All of them, from two surfaces to bounces + 1: `out` holds "specular" or "diffuse" for each surface,
// `back` is empty. Nothing where bounces is 0.
std::vector<SoundPath> bounce_paths(int bounces);

// The scatterers of all paths over two surfaces or more, in a fixed order, whatever the workers. `hits`:
// the direct rays of the fan, as trace_fan gave them.
//
// Each ray goes on from the surface that it meets: as from a mirror, where the material is `kirchhoff`,
// by R of coherent_reflection, and in one direction drawn from the cosine law, by bistatic_strength. At
// each further surface that scatters, the path is connected to the sonar where nothing stands between.
// With W the energy that a ray carries (its solid angle, times R^2 for a mirror and
// pi s(i, o) / (cos i cos o) for a drawn direction), an echo's mean energy is
// W s(i, o) / (cos i r^2), r being the last piece, before absorption. Veach, Robust Monte Carlo Methods
// for Light Transport Simulation (1997), chapter 8.
//
// Each path is heard both ways round, which share amplitude and key. One that scatters at both its
// ends is found from either end, and so each finding has half the energy; one that begins with mirrors
// is found from there alone. A path out over mirrors to a surface that scatters, and back over the same
// mirrors, has the energy W R^2 s(i, i) J / cos i, J = dOmega / dA being the spreading of its ray tube.
// Paths over mirrors alone are sums of parts of the fan's cells, as kirchhoff_scatterers makes them:
// geometry up to the last mirror, (i / lambda) R sqrt(dOmega dA) / r there (Ling, Chou and Lee, IEEE
// Trans. Antennas Propag. 37, 1989). Their parts are found where a ray of the fan leaves the last
// mirror within 0.15 rad of the sonar.
// Paths that leave over one chain of mirrors and come back over another one are not found.
//
// The elevation pattern is that of both directions, the transmit pattern that of the departure.
// `instance` and the place of an echo are those of the last surface that scattered it, or of the last
// mirror where none did; `via` names the instances of all others in the order of the sound.
std::vector<Scatterer> bounced_off_surfaces(const BouncePing& ping, const Fan& fan,
                                            std::span<const Hit> hits, const Workers& workers);

}  // namespace ensonify
