// Objects that are left to be placed.
#pragma once

#include <array>
#include <string>

#include "scenario/path_spec.h"

namespace ensonify {

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
