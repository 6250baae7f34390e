// Flat specular reflectors and the paths over them, by images of the sonar.
//
//   Mirror  LegPair  BouncePlan   make_bounce_plan   fixed for a sequence
//   PlacedMirror  place_mirrors   at the time of a ping, relative to the sonar
//   image_seen_over  Walk  walk   geometry alone, without tracing
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/surface.h"
#include "core/vec.h"
#include "world/world.h"

namespace ensonify {

struct Mirror {
  static constexpr int kNoObject = -1;

  std::string name;
  int object = kNoObject;  // in World::objects; none: horizontal, at z_m
  double z_m = 0;
  int axis = 2;          // of the object's frame, along the normal
  double side = 1;       // +1 or -1: which face of the box; if horizontal, the side of the water
  bool bounded = false;  // a face
  double reflection = 0, roughness_rms_m = 0;
};

// A leg lists the reflectors that sound meets on its path from the sonar; leg 0 is the straight
// path.
using Leg = std::vector<std::uint16_t>;

// Two legs that form one path in each direction; first <= second.
struct LegPair {
  std::uint16_t first = 0, second = 0;
  std::uint16_t out_first = 0;   // path id: out over the first, back over the second
  std::uint16_t out_second = 0;  // of the reverse path; the same if first == second
};

struct BouncePlan {
  int surface = -1, bottom = -1;  // in `mirrors`; -1: none
  std::vector<Mirror> mirrors;    // surface, bottom, objects in order, faces x- x+ y- y+ z- z+
  std::vector<Leg> legs;          // by length, then by mirrors
  std::vector<LegPair> pairs;     // by first, then by second
  std::vector<SoundPath> paths;   // by id; ids by bounces, then by the legs out and back
};

// Empty without `multipath`. `bodies` count only with Multipath::objects. No leg has the same
// reflector twice in a row, or in a row two faces of a body that is seen from outside. Errors
// (usage): no specular reflector, or more than kMaxSoundPaths paths.
Result<BouncePlan> make_bounce_plan(const std::optional<Multipath>& multipath,
                                    std::span<const FlatReflector> bodies);

// Along the axes of the world, with the sonar at the origin.
struct PlacedMirror {
  Vec3 normal;
  double offset_m = 0;  // normal . p = offset_m on it
  bool one_sided = false;
  bool bounded = false;
  Vec3 centre_m, along, across;
  double half_along_m = 0, half_across_m = 0;
  double reflection = 0, roughness_rms_m = 0;
};

std::vector<PlacedMirror> place_mirrors(const BouncePlan& plan, const World& world,
                                        std::span<const Pose> object_in_world, Vec3 sonar_m);

// The image of a point over a leg: in the direction in which the sonar sees it, at the unfolded
// length of the path.
Vec3 image_seen_over(std::span<const PlacedMirror> mirrors, const Leg& leg, Vec3 point_m);

// The path of a ray from the sonar over a leg.
struct Walk {
  std::array<Vec3, kMaxBounces> at_m;
  std::array<double, kMaxBounces> piece_m{};  // up to each reflector
  std::array<Vec3, kMaxBounces + 1> direction;
  double length_m = 0;    // up to the last reflector
  double reflection = 1;  // product over all reflectors, including roughness
};

// Follows a ray over a leg. False if it does not meet the reflectors in order, each within its
// bounds and on its reflecting side, or if length_m would exceed `length_max_m`.
bool walk(std::span<const PlacedMirror> mirrors, const Leg& leg, Vec3 direction,
          double length_max_m, double wavelength_m, Walk& way);

}  // namespace ensonify
