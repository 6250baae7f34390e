// Density grids from OpenVDB files.
#pragma once

#include <filesystem>
#include <string>

#include "core/error.h"
#include "world/density.h"

namespace ensonify {

// Reads the active voxels of one grid of floats, linear between their middles, zero outside; the
// grid's own transform is the volume's frame, in metres.
// Errors (usage, naming the file): a file that is damaged or no .vdb, a grid that is not there, is
// no fog volume of floats, is not placed by a linear transform, has another background than zero,
// is empty or larger than make_density_grid takes, or holds a density that is not from 0 to 1e6.
Result<DensityGrid> load_density_vdb(const std::filesystem::path& file, const std::string& grid);

}  // namespace ensonify
