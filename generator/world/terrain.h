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

// Points `cell_m` apart, with at least two rows and columns, centered at the origin. Columns run
// from west (smallest x) to east, rows from north (largest y) to south.
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

// Roughness has normal heights and is periodic over roughness_period(spec). Its wave vectors lie on
// the lattice of this period, from 0 (left out, so that the mean height is 0) to half the grid's
// sampling rate. Each wave's draw is keyed by its place on the lattice: halving the cell keeps all
// existing waves and adds shorter ones. Ripples are trochoids with a mean of 0 over a period, each
// with a random phase. The heights include relief factors of patches, but no stones (cover.h).
// Needs a spec without a file.
HeightGrid make_seabed(const HeightfieldSpec& spec, std::uint64_t key);

// `key` is the object's (terrain_key); ignored if the heights come from a file.
Result<HeightGrid> height_grid_of(const HeightfieldSpec& spec, std::uint64_t key);

// One factor per point of the grid, by bilinear interpolation of an NPY or PNG file whose corner
// pixels lie on the grid's corners. PNG gives 0 ... 1 from black to white. NPY gives its own
// values, 0 ... 1000.
Result<std::vector<float>> vertex_reflectivity(const std::filesystem::path& file,
                                               const HeightGrid& grid);

struct Terrain {
  HeightGrid grid;
  std::vector<float> reflectivity;  // factors on the material's, one per point; none: 1
};

// `key` as above. Errors: those of height_grid_of and vertex_reflectivity, and of stones and
// patches if their cell and area come from a file. `faulty_key` is then the key below the
// heightfield.
Result<Terrain> make_terrain(const HeightfieldSpec& spec, std::uint64_t key,
                             std::string& faulty_key);

// Each cell has two triangles, counter-clockwise as seen from above and divided by the flatter
// diagonal. A triangle with a hole at a corner is left out. Smooth normals follow from central
// differences, or one-sided ones at the edges and next to holes; they are level along an axis on
// which a point has no neighbor. `reflectivity` is empty or has one value per point.
Mesh heightfield_mesh(const HeightGrid& grid, Normals normals,
                      const std::vector<float>& reflectivity = {});
Mesh terrain_mesh(const HeightfieldSpec& spec, const Terrain& terrain);

}  // namespace ensonify
