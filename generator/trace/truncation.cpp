#include "trace/truncation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "trace/echo.h"
#include "world/shapes.h"

namespace ensonify {
namespace {

std::vector<Patch> patches_of(const MeshShape& shape) {
  std::vector<Patch> patches;
  for (const auto& triangle : shape.mesh->triangles) {
    const auto corner = [&](int k) { return to_vec3(shape.mesh->vertices[triangle[k]]); };
    patches.push_back(TrianglePatch{corner(0), corner(1), corner(2)});
  }
  return patches;
}
std::vector<Patch> patches_of(const PlaneShape&) { return {}; }
template <class Body>
std::vector<Patch> patches_of(const Body& body) {
  return surface_patches(body);
}

double area_of(const Patch& patch) {
  return std::visit([](const auto& p) { return area_m2(p); }, patch);
}

bool is_inside(Vec3 p, const Sonar& sonar) {
  const double range = length(p);
  if (!in_range(range, sonar)) return false;
  const double elevation = std::asin(std::clamp(p.z / range, -1.0, 1.0));
  return std::abs(elevation) <= sonar.elevation_fan_rad / 2 &&
         sector_of(sonar, std::atan2(p.y, p.x)).has_value();
}

}  // namespace

std::vector<Vec3> surface_samples(const Shape& shape) {
  // The fraction of the golden ratio. Steps of this size, combined with steps of equal area, form a
  // lattice.
  constexpr double kGolden = 0.6180339887498949;
  const auto patches = std::visit([](const auto& s) { return patches_of(s); }, shape);
  double whole = 0;
  for (const Patch& patch : patches) whole += area_of(patch);
  std::vector<Vec3> points;
  if (!(whole > 0)) return points;
  const double step = whole / kSurfaceSamples;
  double before = 0;
  for (const Patch& patch : patches) {
    const double area = area_of(patch);
    while (points.size() < std::size_t{kSurfaceSamples}) {
      const double at = (static_cast<double>(points.size()) + 0.5) * step - before;
      if (at >= area && &patch != &patches.back()) break;
      const double v = kGolden * static_cast<double>(points.size() + 1);
      points.push_back(std::visit(
          [&](const auto& p) {
            return point_of(p, std::min(at / area, 1.0), v - std::floor(v)).position_m;
          },
          patch));
    }
    before += area;
  }
  return points;
}

double truncated_share(std::span<const Vec3> points_m, const Pose& object_in_world,
                       const Pose& sonar_in_world, const Sonar& sonar) {
  if (points_m.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto outside = std::ranges::count_if(points_m, [&](Vec3 p) {
    const Vec3 in_world = transform_point(object_in_world, p);
    return !is_inside(inverse_transform_point(sonar_in_world, in_world), sonar);
  });
  return static_cast<double>(outside) / static_cast<double>(points_m.size());
}

}  // namespace ensonify
