// What can be put right in a mesh, and is told.
#pragma once

#include "world/mesh.h"

namespace ensonify {

// Leaves out faces that are no thicker than the rounding of their coordinates (corners that
// coincide or lie in a line): they stop no ray to speak of, and their normals are noise. Adds a
// warning that counts them.
void drop_faces_without_area(Mesh& mesh);

}  // namespace ensonify
