// Normals of surfaces at the positions of echoes, found by new rays because scatterers do not keep
// them.
//
//   surface_normals
#pragma once

#include <cstdint>
#include <span>

#include "core/scatterers.h"
#include "trace/tracer.h"

namespace ensonify {

// For each of the direct scatterers list.items[which[i]]: the normal of its surface there, of unit
// length, in the sonar's frame at transmission, on the side of the sonar; interpolated on smooth
// meshes, as Hit::normal. NaN for point targets and fish, and if no ray finds the surface again.
// `tracer` holds the objects at their poses at transmission.
void surface_normals(const Tracer& tracer, const Pose& sonar_in_world, const ScattererList& list,
                     std::span<const std::uint32_t> which, std::span<Vec3> normals);

}  // namespace ensonify
