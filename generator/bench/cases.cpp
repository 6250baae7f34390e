#include "bench/bench.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.h"

namespace ensonify {
namespace {

// The world is drawn for this range.
constexpr double kDrawnRange_m = 60;
constexpr int kFloorCells = 227;

BenchCase case_of(std::string name, double bandwidth_hz, double range_max_m, int rays_elevation,
                  int rays_azimuth) {
  BenchCase c;
  c.name = std::move(name);
  c.sonar.frequency_hz = 900e3;
  c.sonar.bandwidth_hz = bandwidth_hz;
  c.sonar.source_level_db = 220;
  c.sonar.range_min_m = 0.5;
  c.sonar.range_max_m = range_max_m;
  c.sonar.beam_count = 512;
  c.sonar.beam_spacing_rad = radians(90) / 512;
  c.sonar.beam_width_rad = radians(1);
  c.sonar.elevation_width_rad = radians(20);
  c.sonar.elevation_fan_rad = radians(20);
  c.sonar.rays_elevation = rays_elevation;
  c.sonar.rays_azimuth = rays_azimuth;
  c.water = {1500, 0.2995};
  return c;
}

BenchCase array_case() {
  BenchCase c = case_of("array", 29.9e3, 60, 114, 1);
  ArrayReceiver& array = c.sonar.array.emplace();
  array.elements = 256;
  array.spacing_m = c.water.sound_speed_m_s / c.sonar.frequency_hz / 2;
  array.response.assign(array.elements, 1.0);
  return c;
}

// A basin: seen from the sonar, the floor rises in angle as it goes away, from 20 degrees under the
// level at 6 m to the level at 57 m, so that rays at equal steps of angle meet it at about equal
// steps of range; and it rolls.
double floor_z(double x, double y) {
  const double distance = std::max(6.0, std::hypot(x, y));
  const double depression_rad = radians(20) * (57 - distance) / 51;
  const double roll = 0.15 * std::sin(0.9 * x + 0.3 * y) + 0.1 * std::sin(1.7 * y - 0.4 * x) +
                      0.05 * std::sin(5.3 * x + 4.1 * y);
  return roll - distance * std::tan(depression_rad);
}

std::shared_ptr<const Mesh> floor_mesh(double scale) {
  auto mesh = std::make_shared<Mesh>();
  const int side = kFloorCells + 1;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const double x = -2 + 70.0 * row / kFloorCells;
      const double y = -50 + 100.0 * column / kFloorCells;
      mesh->vertices.push_back({static_cast<float>(scale * x), static_cast<float>(scale * y),
                                static_cast<float>(scale * floor_z(x, y))});
    }
  }
  for (int row = 0; row < kFloorCells; ++row) {
    for (int column = 0; column < kFloorCells; ++column) {
      const auto corner = static_cast<std::uint32_t>(row * side + column);
      const auto next = corner + static_cast<std::uint32_t>(side);
      mesh->triangles.push_back({corner, next, next + 1});
      mesh->triangles.push_back({corner, next + 1, corner + 1});
    }
  }
  return mesh;
}

void add(World& world, const std::string& name, Shape shape, Vec3 position_m, double reflectivity) {
  const auto id = static_cast<std::uint16_t>(world.objects.size() + 1);
  WorldObject object;
  object.instance = id;
  object.shape = std::move(shape);
  object.pose.position_m = position_m;
  object.material.reflectivity = reflectivity;
  Instance instance;
  instance.id = id;
  instance.name = name;
  instance.class_id = static_cast<std::uint8_t>(id);
  instance.class_name = name;
  instance.scattering = object.material;
  world.objects.push_back(std::move(object));
  world.instances.push_back(std::move(instance));
  world.classes.push_back(name);
}

}  // namespace

std::vector<BenchCase> bench_cases() {
  return {case_of("full", 29.9e3, 60, 114, 1), case_of("table1", 2.95e3, 60, 114, 1),
          case_of("reduced", 29.9e3, 10, 11, 1), case_of("dense", 29.9e3, 60, 912, 8),
          array_case()};
}

World make_bench_world(double range_max_m) {
  const double scale = range_max_m / kDrawnRange_m;
  World world;
  add(world, "floor", MeshShape{floor_mesh(scale)}, {}, 1e-3);
  const auto at = [&](double x, double y) { return scale * Vec3{x, y, floor_z(x, y)}; };
  const double s = scale;
  add(world, "box_near", BoxShape{s * Vec3{0.5, 0.4, 0.3}}, at(9, 2), 1e-2);
  add(world, "box_middle", BoxShape{s * Vec3{1, 2, 0.6}}, at(27, -12), 1e-2);
  add(world, "box_far", BoxShape{s * Vec3{0.5, 4, 2}}, at(52, 9), 1e-2);
  add(world, "cylinder_near", CylinderShape{s * 0.3, s * 0.8}, at(12, -4), 1e-2);
  add(world, "cylinder_middle", CylinderShape{s * 0.8, s * 1.5}, at(34, 15), 1e-2);
  add(world, "cylinder_far", CylinderShape{s * 1.0, s * 2.0}, at(45, -25), 1e-2);
  add(world, "sphere_near", SphereShape{s * 0.4}, at(15, 6), 1e-2);
  add(world, "sphere_middle", SphereShape{s * 0.9}, at(22, 1), 1e-2);
  add(world, "sphere_far", SphereShape{s * 1.5}, at(40, -2), 1e-2);
  return world;
}

Pose bench_pose() { return {{0, 0, 0}, from_roll_pitch_yaw(0, radians(10), 0)}; }

}  // namespace ensonify
