// Where things stand: given as poses, or left to be placed.
#pragma once

#include <array>
#include <string>
#include <variant>

#include "core/vec.h"

namespace ensonify {

// Rotation as given: roll, pitch, yaw in degrees (intrinsic z-y'-x'') or a quaternion w x y z of
// any length but zero, which pose_of normalises.
using RotationSpec = std::variant<std::array<double, 3>, Quat>;

struct PoseSpec {
  std::array<double, 3> position_m{};
  RotationSpec rotation = std::array<double, 3>{};
};

// Somewhere in an area, standing on an object. `on` and `area_m` must be given.
struct PlaceSpec {
  std::string on;                                 // name of an object
  std::array<std::array<double, 2>, 2> area_m{};  // corners [x, y] in the world
  double clearance_m = 0.2;                       // between bounding circles, seen from above
  double sink_m = 0;                              // straight down into the ground
  bool any_yaw = true;         // turned by a drawn angle; else as `rotation` says
  bool along_surface = false;  // its z along the ground's normal; else up
  RotationSpec rotation = std::array<double, 3>{};  // before it is turned and aligned
};

}  // namespace ensonify
