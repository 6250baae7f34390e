// One attempt to place an object on another one, or in the water. Private to world/.
//
//   Taken  taken_by  takes_room     occupied space
//   PlaceGround  Body  body_of     the body to be placed, and its ground
//   Attempt  attempt_to_place
//   in_the_way                      the obstacle of a body or of its children
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/random.h"
#include "scenario/scenario.h"
#include "world/convex.h"
#include "world/ground.h"
#include "world/outline.h"
#include "world/world.h"

namespace ensonify {

// Occupied space within an outline, from its low_m to its high_m.
struct Taken {
  std::string name;
  std::string on;   // the object that it was placed on, if any
  Outline outline;  // in the world
  double clearance_m = 0;
};

Taken taken_by(const ObjectSpec& spec, const Outline& of_body, Vec3 position_m);

// Planes and rooms occupy nothing.
bool takes_room(const Shape& shape);

struct PlacedGround {
  std::string name;
  const Ground* ground = nullptr;
  const Shape* shape = nullptr;
  Pose pose;
};

// Surfaces below a body: first its ground, then objects on the ground. For a body in mid-water
// these are the terrain that it must stay above, and the planes that it must not cross.
struct PlaceGround {
  std::vector<PlacedGround> grounds;
  std::optional<Taken> ground_taken;  // by the first ground; none if that is infinite
  std::vector<std::pair<std::string, Pose>> planes;

  // The highest surface under a point; none outside all of them.
  std::optional<GroundPoint> at(double x_m, double y_m) const;
};

struct Body {
  const ObjectSpec& spec;
  const Shape& shape;
  PlaceGround around;
  Quat base;                                 // by place.rotation_deg
  std::vector<Vec3> points;                  // in its own frame
  Outline outline;                           // of `base`
  std::vector<RestFace> faces;               // of `base`; with PlaceAlignment::rest alone
};

// Error (usage): the body has no face to lie on.
Result<Body> body_of(const ObjectSpec& spec, const Shape& shape, PlaceGround around);

struct Attempt {
  std::optional<Pose> pose;
  std::string in_the_way;  // its name; if both are empty: no ground, or no contact
};

// The object that obstructs `own`, which is the body or a child of it; null if there is none. Its
// ground and objects around the ground do not count, and `touched` may be near.
const Taken* in_the_way(const Body& body, const Taken& own, const std::vector<Taken>& taken,
                        const Taken* touched);

Attempt attempt_to_place(const Body& body, const std::vector<Taken>& taken, const Philox4& words);

}  // namespace ensonify
