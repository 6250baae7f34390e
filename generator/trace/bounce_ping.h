// What the echoes over several surfaces of one ping follow from, and the ids of their paths.
//
//   BouncePing                    inputs of one ping
//   path_of_kinds  kThroughWalls  ids of the paths
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface.h"
#include "trace/surface_scattering.h"
#include "trace/tracer.h"
#include "world/world.h"

namespace ensonify {

struct BouncePing {
  const Tracer& tracer;
  const std::vector<Volume>& volumes;
  Pose sonar_in_world;
  const SurfaceScattering& scattering;
  // Number of surfaces beyond the first one, at most kMostBounces. With 0, only paths through walls
  // are found.
  int bounces = 0;
  // The two directions of a path that arrive in one beam cell become one echo with the sum of their
  // gains, as in both_ways_as_one.
  bool ways_as_one = true;
  std::uint64_t key = 0;  // of Stream::bounces
  std::uint32_t ping = 0;
};

// The id of a path over k surfaces is 2^k + kinds. Bit i of `kinds` is 1 if surface i, in the order
// of the sound, reflects specularly, and 0 if it scatters.
constexpr std::uint16_t path_of_kinds(int surfaces, unsigned kinds) {
  return static_cast<std::uint16_t>((1u << surfaces) | kinds);
}

// A bit of the id: the path also passes through walls.
inline constexpr std::uint16_t kThroughWalls = 1u << (kMostBounces + 2);

}  // namespace ensonify
