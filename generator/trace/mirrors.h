// Flat mirrors and the ways over them, by the images of the sonar.
//
//   Mirror  LegPair  BouncePlan   make_bounce_plan   what a sequence fixes
//   PlacedMirror  place_mirrors   at the moment of a ping, seen from the sonar
//   image_seen_over  Walk  walk   geometry alone: nothing is traced
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/surface.h"
#include "core/vec.h"
#include "scenario/scenario.h"
#include "world/world.h"

namespace ensonify {

struct Mirror {
  static constexpr int kNoObject = -1;

  std::string name;
  int object = kNoObject;  // in World::objects; none: horizontal, at z_m
  double z_m = 0;
  int axis = 2;          // of the object's frame, along the normal
  double side = 1;       // +1, -1: of the box's face; of a horizontal one where its water is
  bool bounded = false;  // a face
  double reflection = 0, roughness_rms_m = 0;
};

// A leg is the mirrors that sound meets on its path from the sonar; number 0 is the straight path.
using Leg = std::vector<std::uint16_t>;

// Two legs that make a path each way; first <= second.
struct LegPair {
  std::uint16_t first = 0, second = 0;
  std::uint16_t out_first = 0;   // path: out over the first, back over the second
  std::uint16_t out_second = 0;  // the other way round; the same where first == second
};

struct BouncePlan {
  int surface = -1, bottom = -1;  // in `mirrors`; -1: none
  std::vector<Mirror> mirrors;    // surface, bottom, objects in order, faces x- x+ y- y+ z- z+
  std::vector<Leg> legs;          // by length, then by mirrors
  std::vector<LegPair> pairs;     // by first, then by second
  std::vector<SoundPath> paths;   // by id; ids by bounces, then by the legs out and back
};

// Nothing where the scenario asks for no multipath. No leg has a mirror twice in a row, or two
// faces of a body seen from outside. Errors (usage): no mirror, or more than kMaxSoundPaths
// paths.
Result<BouncePlan> make_bounce_plan(const Scenario& scenario);

// Turned as the world is; the sonar is the origin.
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

// Where the sonar sees a point over a leg: in its direction, at the length of the path.
Vec3 image_seen_over(std::span<const PlacedMirror> mirrors, const Leg& leg, Vec3 point_m);

// How a ray from the sonar goes over a leg.
struct Walk {
  std::array<Vec3, kMaxBounces> at_m;
  std::array<double, kMaxBounces> piece_m{};  // up to each mirror
  std::array<Vec3, kMaxBounces + 1> direction;
  double length_m = 0;    // up to the last mirror
  double reflection = 1;  // of all mirrors, their roughness included
};

// False where the ray does not meet the mirrors one after the other, each within its bounds and on
// the side that it is one from, or where length_m would be above `length_max_m`.
bool walk(std::span<const PlacedMirror> mirrors, const Leg& leg, Vec3 direction,
          double length_max_m, double wavelength_m, Walk& way);

}  // namespace ensonify
