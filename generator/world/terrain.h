// Terrain: heights over a regular grid, from files or synthetic, and the resulting mesh.
//
//   HeightGrid  column_x_m  row_y_m
//   load_height_grid                 from a file
//   terrain_key                      of an object's random numbers
//   roughness_spectrum  make_seabed  a synthetic seabed from a spectrum and ripples
//   height_grid_of                   the heights that a scenario describes
//   vertex_reflectivity              reflectivity factors from an image
//   Terrain  make_terrain            heights and reflectivity, with stones and patches
//   heightfield_mesh  terrain_mesh   both as triangles
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "scenario/terrain_spec.h"
#include "world/mesh.h"

namespace ensonify {

// Points `cell_m` apart, two rows and columns at least, centered at the origin: columns from west
// (x least) to east, rows from north (y largest) to south.
struct HeightGrid {
  int rows = 0, columns = 0;
  double cell_m = 0;
  std::vector<double> heights_m;  // row-major; NaN: a hole
};

inline double column_x_m(const HeightGrid& grid, int column) {
  return (column - 0.5 * (grid.columns - 1)) * grid.cell_m;
}
inline double row_y_m(const HeightGrid& grid, int row) {
  return (0.5 * (grid.rows - 1) - row) * grid.cell_m;
}

// height = scale * value + offset. For ESRI ASCII, `cell_m` and the corner are ignored. Holes:
// NODATA of ESRI ASCII, NaN of NPY. Errors: those of load_grid_file, and heights or sides beyond
// 1e7 m.
Result<HeightGrid> load_height_grid(const std::filesystem::path& file, double cell_m, double scale,
                                    double offset_m);

std::uint64_t terrain_key(std::uint64_t seed, SequenceDraw draw, std::string_view object);

// W2(K) in m^4, over all wave vectors (two-sided): its integral over the plane is rms^2.
//   W2 = rms^2 (g - 2) / (2 pi) K0^(g - 2) (K^2 + K0^2)^(-g/2),  K0 = 2 pi / outer scale
double roughness_spectrum(const RoughnessSpec& roughness, double wave_number_rad_m);

// Roughness: normal heights, periodic over roughness_period(spec), whose wave vectors lie on that
// period's lattice between 0 (left out: the mean height is 0) and half the grid's sampling rate.
// Each wave's draw is keyed by its place on the lattice: halving the cell keeps all existing waves
// and adds shorter ones. Ripples: trochoids of period mean 0, each with a random phase. Relief
// factors of patches count; stones are not among the heights (cover.h). Needs a spec without a
// file.
HeightGrid make_seabed(const HeightfieldSpec& spec, std::uint64_t key);

// `key` is the object's (terrain_key); ignored if the heights come from a file.
Result<HeightGrid> height_grid_of(const HeightfieldSpec& spec, std::uint64_t key);

// One factor a point of the grid, bilinear from an NPY or PNG file whose corner pixels lie on the
// grid's corners. Of PNG: 0 ... 1 from black to white; of NPY: as they stand there, 0 ... 1000.
Result<std::vector<float>> vertex_reflectivity(const std::filesystem::path& file,
                                               const HeightGrid& grid);

struct Terrain {
  HeightGrid grid;
  std::vector<float> reflectivity;  // factors on the material's, one a point; none: 1 everywhere
};

// `key` as above. Errors: those of height_grid_of and vertex_reflectivity, and of stones and
// patches whose cell and area a file brings; `faulty_key` is then the key below the heightfield.
Result<Terrain> make_terrain(const HeightfieldSpec& spec, std::uint64_t key,
                             std::string& faulty_key);

// Two triangles a cell, seen counter-clockwise from above, parted along the flatter diagonal. A
// hole takes every triangle that it is a corner of. Smooth normals are those of central
// differences, one-sided at the edges and beside holes, level
// along an axis on which a point stands alone. `reflectivity` is empty or one a point.
Mesh heightfield_mesh(const HeightGrid& grid, Normals normals,
                      const std::vector<float>& reflectivity = {});
Mesh terrain_mesh(const HeightfieldSpec& spec, const Terrain& terrain);

}  // namespace ensonify
