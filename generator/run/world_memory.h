// Memory of worlds.
//
//   world_bytes  hierarchy_bytes  unshared_bytes   of a world
//   terrain_bytes               of a synthetic seabed, before it is made
#pragma once

#include <cstdint>

#include "scenario/scenario.h"
#include "world/world.h"

namespace ensonify {

// The memory of a world with its hierarchies, independent of how many sequences share it.
std::uint64_t world_bytes(const World& world);

// What its tracer adds to a world, and what is kept of each object.
std::uint64_t hierarchy_bytes(const World& world);

// Loaded data that each world has for itself, without the meshes of files.
std::uint64_t unshared_bytes(const World& world);

// What a synthetic seabed takes with its hierarchies, or while it is made; 0 for one from a file.
double terrain_bytes(const HeightfieldSpec& spec);

}  // namespace ensonify
