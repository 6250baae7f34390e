#include "world/density.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ensonify {
namespace {

constexpr int kCells = DensityGrid::kCells, kCorners = DensityGrid::kCorners;

int brick_of(int index) { return (index >= 0 ? index : index - (kCells - 1)) / kCells; }

std::array<int, 3> first_sample(const DensityGrid& grid, std::size_t cell) {
  const std::size_t x = cell % grid.bricks[0], row = cell / grid.bricks[0];
  const std::size_t y = row % grid.bricks[1], z = row / grid.bricks[1];
  return {grid.origin[0] + static_cast<int>(x) * kCells,
          grid.origin[1] + static_cast<int>(y) * kCells,
          grid.origin[2] + static_cast<int>(z) * kCells};
}

}  // namespace

Result<DensityGrid> make_density_grid(const DensitySource& source, const Affine& index_from_local,
                                      double spacing_m) {
  DensityGrid grid;
  grid.index_from_local = index_from_local;
  grid.spacing_m = spacing_m;
  std::size_t cells = 1;
  for (int i = 0; i < 3; ++i) {
    // The cells below the first sample count as well, because the density rises from zero there.
    const int first = brick_of(source.low[i] - 1), last = brick_of(source.high[i]);
    grid.origin[i] = first * kCells;
    grid.bricks[i] = last - first + 1;
    cells *= static_cast<std::size_t>(grid.bricks[i]);
    if (cells > kMaxTopCells) {
      return Error{ErrorKind::usage,
                   "extends over more than 2048^3 voxels; expected a smaller or coarser grid"};
    }
  }
  grid.top.assign(cells, -1);
  // Bricks are counted first, so that memory is allocated only once.
  std::vector<std::size_t> filled;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (!source.is_empty(first_sample(grid, cell))) filled.push_back(cell);
  }
  if (filled.size() > kMaxBricks) {
    return Error{ErrorKind::usage,
                 fmt::format("holds density in {} bricks of {}^3 voxels; expected at most {}: make "
                             "the grid sparser or coarser",
                             filled.size(), kCells, kMaxBricks)};
  }
  grid.samples.resize(filled.size() * DensityGrid::kBrickSamples);
  std::size_t count = 0;
  for (const std::size_t cell : filled) {
    float* brick = grid.samples.data() + count * DensityGrid::kBrickSamples;
    source.fill(first_sample(grid, cell), brick);
    const bool empty =
        std::all_of(brick, brick + DensityGrid::kBrickSamples, [](float v) { return v == 0; });
    if (!empty) grid.top[cell] = static_cast<std::int32_t>(count++);
  }
  grid.samples.resize(count * DensityGrid::kBrickSamples);
  return grid;
}

float density_in_brick(const float* brick, Vec3 from_corner) {
  const auto cell = [](double u) { return std::clamp(static_cast<int>(u), 0, kCells - 1); };
  const int x = cell(from_corner.x), y = cell(from_corner.y), z = cell(from_corner.z);
  const auto fx = static_cast<float>(from_corner.x - x), fy = static_cast<float>(from_corner.y - y),
             fz = static_cast<float>(from_corner.z - z);
  const float* s = brick + (z * kCorners + y) * kCorners + x;
  const auto along_x = [&](const float* row) { return row[0] + fx * (row[1] - row[0]); };
  const auto along_y = [&](const float* plane) {
    const float low = along_x(plane);
    return low + fy * (along_x(plane + kCorners) - low);
  };
  const float low = along_y(s);
  return low + fz * (along_y(s + kCorners * kCorners) - low);
}

float density_at(const DensityGrid& grid, Vec3 index) {
  const std::array<double, 3> p = {index.x, index.y, index.z};
  std::array<int, 3> brick{};
  std::array<double, 3> from{};
  for (int i = 0; i < 3; ++i) {
    const double u = (p[i] - grid.origin[i]) / kCells;
    if (!(u >= 0 && u < grid.bricks[i])) return 0;
    brick[i] = static_cast<int>(u);
    from[i] = p[i] - (grid.origin[i] + brick[i] * kCells);
  }
  const std::size_t cell =
      (std::size_t(brick[2]) * grid.bricks[1] + brick[1]) * grid.bricks[0] + brick[0];
  const std::int32_t number = grid.top[cell];
  if (number < 0) return 0;
  return density_in_brick(grid.samples.data() + std::size_t(number) * DensityGrid::kBrickSamples,
                          {from[0], from[1], from[2]});
}

}  // namespace ensonify
