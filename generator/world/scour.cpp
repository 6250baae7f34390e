#include "world/scour.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string_view>

#include "core/error.h"
#include "core/units.h"
#include "scenario/scenario.h"

namespace ensonify {
namespace {

double perimeter_m(const Outline& outline) {
  double length_m = 2 * kPi * outline.round_m;
  for (std::size_t i = 0; i < outline.hull_m.size(); ++i) {
    const auto& [ax, ay] = outline.hull_m[i];
    const auto& [bx, by] = outline.hull_m[(i + 1) % outline.hull_m.size()];
    length_m += std::hypot(bx - ax, by - ay);
  }
  return length_m;
}

double hump(double u) {
  const double root = std::sin(kPi * u);
  return root * root;
}

// The first index of the points within `reach_m` of a coordinate, and one past the last.
std::array<int, 2> index_range(double at_m, double reach_m, double cell_m, int count) {
  const auto index = [&](double from_first_m) {
    const double i = from_first_m / cell_m + 0.5 * (count - 1);
    return static_cast<int>(std::clamp(i, 0.0, double(count)));
  };
  return {index(at_m - reach_m), std::min(index(at_m + reach_m) + 1, count)};
}

}  // namespace

ScourShape scour_shape(const ScourSpec& spec, const Outline& outline) {
  ScourShape shape{spec.depth_m, spec.width_m, spec.mound_m.value_or(spec.depth_m / 2), 0, {}};
  if (spec.direction_deg) shape.flow_rad = radians(*spec.direction_deg);
  if (!(shape.depth_m > 0 && shape.mound_m > 0)) return shape;
  const double perimeter = perimeter_m(outline), width = shape.width_m;
  const double half = perimeter / 2 + kPi * width;
  const double volume = shape.depth_m / shape.mound_m * width * (perimeter + kPi * width);
  shape.mound_width_m = volume / (half + std::sqrt(half * half + kPi * volume));
  return shape;
}

double scour_m(const ScourShape& shape, const Gap& from_outline) {
  const double d = from_outline.distance_m;
  if (!(d > 0 && d < shape.width_m + shape.mound_width_m)) return 0;
  const bool in_pit = d < shape.width_m;
  double share = 1;
  if (shape.flow_rad) {
    const double cosine =
        std::cos(*shape.flow_rad) * from_outline.x + std::sin(*shape.flow_rad) * from_outline.y;
    share = (in_pit ? 1 - cosine : 1 + cosine) / 2;
  }
  if (in_pit) return -shape.depth_m * share * hump(d / shape.width_m);
  return shape.mound_m * share * hump((d - shape.width_m) / shape.mound_width_m);
}

void scour(const ScourSpec& spec, const Outline& outline, const Pose& terrain, HeightGrid& grid) {
  const ScourShape shape = scour_shape(spec, outline);
  const double reach_m = outline.radius_m + shape.width_m + shape.mound_width_m;
  const Vec3 center = inverse_transform_point(terrain, {outline.x_m, outline.y_m, 0});
  // In a tilted frame, points within reach of the center in the world lie farther from it.
  const bool upright = rotate(terrain.rotation, {0, 0, 1}).z > 1 - 1e-12;
  const auto range = [&](double at_m, int count) {
    return upright ? index_range(at_m, reach_m, grid.cell_m, count) : std::array{0, count};
  };
  const auto [first_row, end_row] = range(-center.y, grid.rows);
  const auto [first_column, end_column] = range(center.x, grid.columns);
  for (int row = first_row; row < end_row; ++row) {
    for (int column = first_column; column < end_column; ++column) {
      double& height_m = grid.heights_m[std::size_t(row) * grid.columns + column];
      const Vec3 p =
          transform_point(terrain, {column_x_m(grid, column), row_y_m(grid, row), height_m});
      if (!(std::hypot(p.x - outline.x_m, p.y - outline.y_m) < reach_m)) continue;
      height_m += scour_m(shape, gap_between(outline, {{{p.x, p.y}}, 0, p.x, p.y, 0, 0, 0}));
    }
  }
}

ScouredTerrain scoured_terrain(const Scenario& scenario) {
  ScouredTerrain scoured;
  for (const ObjectSpec& spec : scenario.objects) {
    if (spec.place && spec.place->scour) scoured.try_emplace(spec.place->on);
  }
  return scoured;
}

void scour_terrain(const Scenario& scenario, ScouredTerrain& scoured, World& world) {
  if (scoured.empty()) return;
  std::map<std::string_view, WorldObject*> by_name;
  for (WorldObject& object : world.objects) {
    by_name.emplace(world.instances[object.instance - 1].name, &object);
  }
  for (const ObjectSpec& spec : scenario.objects) {
    const auto found = by_name.find(spec.name);
    if (!spec.place || !spec.place->scour || found == by_name.end()) continue;
    const WorldObject& object = *found->second;
    const Outline outline = outline_of(object.shape, object.pose.rotation);
    scour(*spec.place->scour, moved(outline, object.pose.position_m),
          by_name.at(spec.place->on)->pose, scoured.at(spec.place->on).grid);
  }
  for (const ObjectSpec& spec : scenario.objects) {
    const auto terrain = scoured.find(spec.name);
    const auto found = by_name.find(spec.name);
    if (terrain == scoured.end() || found == by_name.end()) continue;
    const auto* field = std::get_if<HeightfieldSpec>(&spec.shape);
    ENSONIFY_ASSERT(field != nullptr);
    WorldObject& object = *found->second;
    object.shape =
        MeshShape{std::make_shared<const Mesh>(terrain_mesh(*field, terrain->second)), true};
    world.instances[object.instance - 1].box = box_of(object.shape);
  }
}

}  // namespace ensonify
