// The water and the worlds of most tests of trace/.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/sonar.h"
#include "world/world.h"

namespace ensonify {

inline const Water kWater{1500, 0.3};

// Objects of the ids 1, 2, ... without a material.
inline World world_of(std::vector<std::pair<Shape, Pose>> things) {
  World world;
  for (auto& [shape, pose] : things) {
    const auto id = static_cast<std::uint32_t>(world.objects.size() + 1);
    world.objects.push_back({id, std::move(shape), pose, {}});
    world.instances.push_back({});
  }
  return world;
}

}  // namespace ensonify
