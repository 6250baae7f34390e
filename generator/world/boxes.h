// Boxes around what stands in the world: the labels' 3-D boxes.
#pragma once

#include <optional>

#include "core/ping.h"
#include "world/volumes.h"
#include "world/world.h"

namespace ensonify {

// Along the axes of the object's own frame; none for a plane. Of a mesh: around its vertices.
std::optional<OrientedBox> box_of(const Shape& shape);

// In the world. Of a school: around its fish, along the world's axes; none without fish. Of a
// density grid: around the bricks that hold anything, a cell of 8 samples wide at most too large on
// every side; none for a density without end or an empty grid.
std::optional<OrientedBox> box_of(const Volume& volume);
std::optional<OrientedBox> box_of(const School& school);

}  // namespace ensonify
