// One try to put an object on another one. Private to world/.
//
//   Taken  taken_by  takes_room   room that is taken
//   Body  body_of                 what is to be placed
//   Attempt  attempt_to_place
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/random.h"
#include "world/convex.h"
#include "world/ground.h"
#include "world/outline.h"
#include "world/world.h"

namespace ensonify {

// What lies within an outline, from its low_m to its high_m.
struct Taken {
  std::string name;
  std::string on;   // what it stands on, if it was placed
  Outline outline;  // in the world
  double clearance_m = 0;
};

Taken taken_by(const ObjectSpec& spec, const Outline& of_body, Vec3 position_m);

// A plane and a room take nothing.
bool takes_room(const Shape& shape);

struct Body {
  const ObjectSpec& spec;
  const Shape& shape;
  const Ground& ground;
  const std::optional<Taken>& ground_taken;  // nothing for a ground without end
  Quat base;                                 // as place.rotation_deg lays it
  std::vector<Vec3> points;                  // in its own frame
  Outline outline;                           // of `base`
  std::vector<RestFace> faces;               // of `base`; with PlaceAlignment::rest alone
};

// Error (usage): the body has no face to lie on.
Result<Body> body_of(const ObjectSpec& spec, const Shape& shape, const Ground& ground,
                     const std::optional<Taken>& ground_taken);

struct Attempt {
  std::optional<Pose> pose;
  const Taken* in_the_way = nullptr;  // neither: no ground, or nothing to touch
};

Attempt attempt_to_place(const Body& body, const std::vector<Taken>& taken, const Philox4& words);

}  // namespace ensonify
