#include "scenario/terrain_spec.h"

#include <algorithm>
#include <cmath>

namespace ensonify {
namespace {

int cells_along(double size_m, double cell_m) {
  return std::max(1, static_cast<int>(std::lround(size_m / cell_m)));
}

}  // namespace

std::array<int, 2> vertices_along(const HeightfieldSpec& field) {
  return {cells_along(field.size_m[0], field.cell_m) + 1,
          cells_along(field.size_m[1], field.cell_m) + 1};
}

std::array<std::int64_t, 2> roughness_period(const HeightfieldSpec& field) {
  const std::array<int, 2> vertices = vertices_along(field);
  const double outer_m = field.roughness ? field.roughness->outer_scale_m : 0;
  const double least = std::min(outer_m, std::max(field.size_m[0], field.size_m[1])) / field.cell_m;
  std::array<std::int64_t, 2> period{2, 2};
  for (int side = 0; side < 2; ++side) {
    while (period[side] < vertices[side] || static_cast<double>(period[side]) < least) {
      period[side] *= 2;
    }
  }
  return period;
}

}  // namespace ensonify
