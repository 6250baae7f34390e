// Density fields in the water, plain data for the tracer: scattering and attenuation are
// proportional to the density.
//
//   DensityEverywhere  DensityBox   closed forms
//   DensityGrid                     sparse grid of samples   make_density_grid  density_at
//   load_density_vdb                a grid from an OpenVDB file
//   DensityField                    one of them
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/error.h"
#include "core/vec.h"

namespace ensonify {

struct DensityEverywhere {};  // density 1, without end

// Density 1 inside a box that is centered at the origin.
struct DensityBox {
  Vec3 half_extents_m;
};

// p -> (rows . p) + offset.
struct Affine {
  std::array<Vec3, 3> rows{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Vec3 offset;
};
inline Vec3 turned(const Affine& a, Vec3 v) {
  return {dot(a.rows[0], v), dot(a.rows[1], v), dot(a.rows[2], v)};
}
inline Vec3 mapped(const Affine& a, Vec3 p) { return turned(a, p) + a.offset; }

// Samples lie at whole indices; the density is linear between them and zero beyond the outermost
// ones. A dense top level points to bricks of 8^3 cells. A brick holds the 9^3 samples at the
// corners of its cells, so that a look-up needs only one brick. It exists only if one of its
// samples is not zero.
struct DensityGrid {
  static constexpr int kCells = 8, kCorners = 9;
  static constexpr int kBrickSamples = kCorners * kCorners * kCorners;

  Affine index_from_local;        // from the volume's own frame, in meters
  double spacing_m = 0;           // the least between neighboring samples
  std::array<int, 3> origin{};    // index of the first brick's first sample
  std::array<int, 3> bricks{};    // how many along each axis
  std::vector<std::int32_t> top;  // [z][y][x]: number of the brick; -1: nothing there
  std::vector<float> samples;     // [brick][z][y][x]

  std::size_t bytes() const { return top.size() * 4 + samples.size() * sizeof(float); }
};

using DensityField =
    std::variant<DensityEverywhere, DensityBox, std::shared_ptr<const DensityGrid>>;

// Limits of a grid: 2^28 cells in bricks, 2048^3 cells in extent.
inline constexpr std::size_t kMaxTopCells = std::size_t{1} << 24;
inline constexpr std::size_t kMaxBricks = std::size_t{1} << 19;

// The source has all samples within [low, high], both included. `fill` writes the samples of one
// box of 9^3 that starts at an index, with zeros where the source has none. It is called only if
// `is_empty` of the same box is false. Error (usage): the bricks do not fit, or exceed
// kMaxTopCells.
struct DensitySource {
  std::array<int, 3> low{}, high{};
  std::function<bool(std::array<int, 3> first)> is_empty;
  std::function<void(std::array<int, 3> first, float* samples)> fill;
};
Result<DensityGrid> make_density_grid(const DensitySource& source, const Affine& index_from_local,
                                      double spacing_m);

// Density at a point within this brick, given in indices from the brick's first sample.
float density_in_brick(const float* brick, Vec3 from_corner);

// Density at any point.
float density_at(const DensityGrid& grid, Vec3 index);

// Reads the active voxels of one grid of floats. The density is linear between the middles of
// voxels and zero outside. The grid's own transform gives the volume's frame, in meters. Errors
// (usage, naming the file): a file that is damaged or not a .vdb; a grid that is missing, not a fog
// volume of floats, has no linear transform or a background other than zero, is empty or larger
// than make_density_grid allows, or holds a density outside 0 to 1e6.
Result<DensityGrid> load_density_vdb(const std::filesystem::path& file, const std::string& grid);

}  // namespace ensonify
