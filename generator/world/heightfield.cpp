#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/vec.h"
#include "world/cover.h"
#include "world/grid_file.h"
#include "world/terrain.h"

namespace ensonify {

Result<HeightGrid> load_height_grid(const std::filesystem::path& file, double cell_m, double scale,
                                    double offset_m) {
  constexpr double kMaxLength_m = 1e7;  // as of lengths in a scenario
  Result<GridFile> read = load_grid_file(file);
  if (!read) return read.error();
  HeightGrid grid{read->rows, read->columns, read->cell_m > 0 ? read->cell_m : cell_m,
                  std::move(read->values)};
  const auto wrong = [&](const std::string& why) {
    return Error{ErrorKind::usage, fmt::format("{}: {}", file.string(), why)};
  };
  const double side_m = (std::max(grid.rows, grid.columns) - 1) * grid.cell_m;
  if (!(side_m <= kMaxLength_m)) {
    return wrong(
        fmt::format("its longer side is {} m; expected at most {} m", side_m, kMaxLength_m));
  }
  bool all_holes = true;
  for (std::size_t i = 0; i < grid.heights_m.size(); ++i) {
    double& height = grid.heights_m[i];
    if (std::isnan(height)) continue;
    all_holes = false;
    height = scale * height + offset_m;
    if (std::abs(height) <= kMaxLength_m) continue;
    return wrong(fmt::format("the height in row {}, column {} is {} m; expected at most {} m",
                             i / grid.columns, i % grid.columns, height, kMaxLength_m));
  }
  if (all_holes) return wrong("holds no heights");
  return grid;
}

namespace {

constexpr std::uint32_t kHole = std::numeric_limits<std::uint32_t>::max();
constexpr double kMaxFactor = 1000;

// Slope between the neighbors of a point; `before` and `after` are NaN if missing.
double slope(double before, double here, double after, double step_m) {
  if (std::isnan(before) && std::isnan(after)) return 0;
  if (std::isnan(before)) return (after - here) / step_m;
  if (std::isnan(after)) return (here - before) / step_m;
  return (after - before) / (2 * step_m);
}

std::array<float, 3> smooth_normal(const HeightGrid& grid, int row, int column) {
  const auto height = [&](int r, int c) {
    if (r < 0 || c < 0 || r >= grid.rows || c >= grid.columns) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    return grid.heights_m[std::size_t(r) * grid.columns + c];
  };
  const double here = height(row, column);
  const double east = slope(height(row, column - 1), here, height(row, column + 1), grid.cell_m);
  const double north = slope(height(row + 1, column), here, height(row - 1, column), grid.cell_m);
  const Vec3 n = normalized(Vec3{-east, -north, 1});
  return to_floats(n);
}

// Adds the points that are not holes; returns the vertex of each point.
std::vector<std::uint32_t> add_vertices(const HeightGrid& grid, Normals normals,
                                        const std::vector<float>& reflectivity, Mesh& mesh) {
  std::vector<std::uint32_t> vertex_of(grid.heights_m.size(), kHole);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const std::size_t point = std::size_t(row) * grid.columns + column;
      const double height = grid.heights_m[point];
      if (std::isnan(height)) continue;
      vertex_of[point] = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(to_floats({column_x_m(grid, column), row_y_m(grid, row), height}));
      if (normals == Normals::smooth) mesh.normals.push_back(smooth_normal(grid, row, column));
      if (!reflectivity.empty()) mesh.reflectivity.push_back(reflectivity[point]);
    }
  }
  return vertex_of;
}

void add_cell(const std::array<std::uint32_t, 4>& corners, bool along_first, Mesh& mesh) {
  const auto [nw, sw, se, ne] = corners;
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a != kHole && b != kHole && c != kHole) mesh.triangles.push_back({a, b, c});
  };
  if (along_first) {  // from north-west to south-east
    add(nw, sw, se);
    add(nw, se, ne);
  } else {
    add(nw, sw, ne);
    add(sw, se, ne);
  }
}

// The value by bilinear interpolation; row and column run from 0 to rows - 1 and columns - 1 of the
// file.
double value_at(const GridFile& file, double row, double column) {
  const int r = std::min(static_cast<int>(row), file.rows - 2);
  const int c = std::min(static_cast<int>(column), file.columns - 2);
  const double v = row - r, u = column - c;
  const double* first = &file.values[std::size_t(r) * file.columns + c];
  const double* second = first + file.columns;
  return (1 - v) * ((1 - u) * first[0] + u * first[1]) + v * ((1 - u) * second[0] + u * second[1]);
}

}  // namespace

Result<HeightGrid> height_grid_of(const HeightfieldSpec& spec, std::uint64_t key) {
  if (spec.file.empty()) return make_seabed(spec, key);
  return load_height_grid(spec.file, spec.cell_m, spec.height_scale, spec.height_offset_m);
}

Result<std::vector<float>> vertex_reflectivity(const std::filesystem::path& file,
                                               const HeightGrid& grid) {
  const Result<GridFile> map = load_grid_file(file);
  if (!map) return map.error();
  for (std::size_t i = 0; i < map->values.size(); ++i) {
    if (map->values[i] >= 0 && map->values[i] <= kMaxFactor) continue;
    if (map->white > 0) break;
    return Error{
        ErrorKind::usage,
        fmt::format("{}: the factor in row {}, column {} is {}; expected 0 to {}", file.string(),
                    i / map->columns, i % map->columns, map->values[i], kMaxFactor)};
  }
  const double scale = map->white > 0 ? 1 / map->white : 1;
  std::vector<float> factors(grid.heights_m.size());
  for (int row = 0; row < grid.rows; ++row) {
    const double at_row = double(row) * (map->rows - 1) / (grid.rows - 1);
    for (int column = 0; column < grid.columns; ++column) {
      const double at_column = double(column) * (map->columns - 1) / (grid.columns - 1);
      factors[std::size_t(row) * grid.columns + column] =
          static_cast<float>(scale * value_at(*map, at_row, at_column));
    }
  }
  return factors;
}

namespace {

// Finds errors that only the content of the file shows; the returned key is below the heightfield.
std::optional<CoverFault> cover_fault(const HeightfieldSpec& spec, const HeightGrid& grid) {
  const std::array<double, 2> size_m{(grid.columns - 1) * grid.cell_m,
                                     (grid.rows - 1) * grid.cell_m};
  for (std::size_t i = 0; i < spec.patches.size(); ++i) {
    const auto fault = patch_fault(spec.patches[i], grid.cell_m);
    if (fault) return CoverFault{fmt::format("patches.{}.{}", i, fault->key), fault->what};
  }
  for (std::size_t i = 0; i < spec.stones.size(); ++i) {
    const auto fault = stone_fault(spec.stones[i], grid.cell_m, size_m);
    if (fault) return CoverFault{fmt::format("stones.{}.{}", i, fault->key), fault->what};
  }
  return std::nullopt;
}

}  // namespace

Result<Terrain> make_terrain(const HeightfieldSpec& spec, std::uint64_t key,
                             std::string& faulty_key) {
  faulty_key = "file";
  Result<HeightGrid> grid = height_grid_of(spec, key);
  if (!grid) return grid.error();
  Terrain terrain{std::move(*grid), {}};
  if (const auto fault = cover_fault(spec, terrain.grid)) {
    faulty_key = fault->key;
    return Error{ErrorKind::usage, fault->what};
  }
  if (!spec.reflectivity_map.empty()) {
    faulty_key = "reflectivity_map";
    Result<std::vector<float>> loaded = vertex_reflectivity(spec.reflectivity_map, terrain.grid);
    if (!loaded) return loaded.error();
    terrain.reflectivity = std::move(*loaded);
  }
  lay_patches(spec.patches, key, terrain.grid, terrain.reflectivity);
  lay_stones(spec.stones, key, terrain.grid, terrain.reflectivity);
  return terrain;
}

Mesh heightfield_mesh(const HeightGrid& grid, Normals normals,
                      const std::vector<float>& reflectivity) {
  Mesh mesh;
  const std::vector<std::uint32_t> vertex_of = add_vertices(grid, normals, reflectivity, mesh);
  const std::size_t columns = grid.columns;
  mesh.triangles.reserve(2 * (grid.rows - 1) * (columns - 1));
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (std::size_t column = 0; column + 1 < columns; ++column) {
      const std::size_t nw = row * columns + column, sw = nw + columns;
      const double first = std::abs(grid.heights_m[nw] - grid.heights_m[sw + 1]);
      const double second = std::abs(grid.heights_m[nw + 1] - grid.heights_m[sw]);
      // A diagonal that ends in a hole would leave only one triangle.
      const bool along_first = !std::isnan(first) && !(second < first);
      add_cell({vertex_of[nw], vertex_of[sw], vertex_of[sw + 1], vertex_of[nw + 1]}, along_first,
               mesh);
    }
  }
  return mesh;
}

Mesh terrain_mesh(const HeightfieldSpec& spec, const Terrain& terrain) {
  return heightfield_mesh(terrain.grid, spec.smooth_normals ? Normals::smooth : Normals::face,
                          terrain.reflectivity);
}

}  // namespace ensonify
