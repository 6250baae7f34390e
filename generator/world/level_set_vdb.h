// Solid objects from OpenVDB level sets.
#pragma once

#include <filesystem>
#include <string>

#include "core/error.h"
#include "world/mesh.h"

namespace ensonify {

// The zero surface of one grid of floats as triangles, seen counter-clockwise from where the
// distance is positive, two to each voxel that it passes through; in metres, by the grid's own
// transform. Smooth normals are the means of the faces around a vertex, weighted by area. `grid`
// may be empty where the file holds one.
// Errors (usage, naming the file): a file that is damaged or no .vdb, a grid that is not there, is
// no level set of floats, is not placed by a linear transform, has a background that is not above
// zero (inside out), holds a distance that is no finite number, or has no surface.
Result<Mesh> load_level_set_vdb(const std::filesystem::path& file, const std::string& grid,
                                Normals normals);

}  // namespace ensonify
