// Terrain as a mesh.
//
//   height_grid_of         the heights that a scenario describes
//   vertex_reflectivity    a picture laid over them
//   heightfield_mesh       both as triangles
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/error.h"
#include "scenario/terrain_spec.h"
#include "world/height_grid.h"
#include "world/mesh.h"

namespace ensonify {

// `key` is the object's (terrain_key); not looked at where the heights come from a file.
Result<HeightGrid> height_grid_of(const HeightfieldSpec& spec, std::uint64_t key);

// One factor a point of the grid, bilinear from an NPY or PNG file whose corner pixels lie on the
// grid's corners. Of PNG: 0 ... 1 from black to white; of NPY: as they stand there, 0 ... 1000.
Result<std::vector<float>> vertex_reflectivity(const std::filesystem::path& file,
                                               const HeightGrid& grid);

// Two triangles a cell, seen counter-clockwise from above, parted along the flatter diagonal. A
// hole takes every triangle that it is a corner of. Smooth normals are those of central
// differences, one-sided at the edges and beside holes, level
// along an axis on which a point stands alone. `reflectivity` is empty or one a point.
Mesh heightfield_mesh(const HeightGrid& grid, Normals normals,
                      const std::vector<float>& reflectivity = {});

}  // namespace ensonify
