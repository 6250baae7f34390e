// The water and the worlds of most tests of trace/, and what their echoes add up to.
//
//   world_of     objects without a material
//   world_with   one object of a material
//   add_object   one more
//   mesh_box     a box of triangles
//   sum_of_echoes
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "acoustics/pattern.h"
#include "core/scatterers.h"
#include "core/sonar.h"
#include "core/units.h"
#include "world/world.h"

namespace ensonify {

inline const Water kWater{1500, 0.3};

// With the next id: 1, 2, ...
inline void add_object(World& world, Shape shape, const Pose& pose = {},
                       const Material& material = {}) {
  const auto id = static_cast<std::uint32_t>(world.objects.size() + 1);
  world.objects.push_back({id, std::move(shape), pose, material});
  world.instances.resize(world.objects.size());
}

inline World world_of(std::vector<std::pair<Shape, Pose>> things) {
  World world;
  for (auto& [shape, pose] : things) add_object(world, std::move(shape), pose);
  return world;
}

inline World world_with(Shape shape, const Pose& pose = {}, const Material& material = {}) {
  World world;
  add_object(world, std::move(shape), pose, material);
  return world;
}

// Of these half sides, about the origin.
inline Shape mesh_box(float x, float y, float z) {
  auto mesh = std::make_shared<Mesh>();
  for (int i = 0; i < 8; ++i) {
    mesh->vertices.push_back({i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z});
  }
  mesh->triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                     {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return MeshShape{mesh};
}

// sum of a r^-2 e^(-i 2 pi f (delay - that of reference_m)), 1500 m/s, with the pattern of this
// width in elevation divided out.
inline std::complex<double> sum_of_echoes(const std::vector<Scatterer>& scatterers,
                                          double frequency_hz, double reference_m,
                                          double elevation_width_rad = radians(20)) {
  std::complex<double> sum = 0;
  for (const Scatterer& s : scatterers) {
    const double pattern = line_pattern(s.arrival.elevation_rad, elevation_width_rad);
    sum += std::complex<double>(s.mean) * (s.gain / pattern) *
           std::polar(1.0, -2 * kPi * frequency_hz * (s.delay_s - 2 * reference_m / 1500));
  }
  return sum;
}

}  // namespace ensonify
