// Normals of surfaces at the places of echoes, found again by rays: scatterers do not keep them.
//
//   surface_normals
#pragma once

#include <cstdint>
#include <span>

#include "core/scatterers.h"
#include "trace/tracer.h"

namespace ensonify {

// For each of the direct scatterers list.items[which[i]]: the normal of its instance where it lies,
// of unit length, in the sonar's frame at transmission, on the side of the sonar; as Hit::normal,
// so interpolated where a mesh is smooth. NaN for point targets and fish, and where no ray finds
// the surface again. `tracer` has everything where it is at transmission.
void surface_normals(const Tracer& tracer, const Pose& sonar_in_world, const ScattererList& list,
                     std::span<const std::uint32_t> which, std::span<Vec3> normals);

}  // namespace ensonify
