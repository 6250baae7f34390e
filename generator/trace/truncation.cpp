#include "trace/truncation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "trace/echo.h"
#include "world/shapes.h"

namespace ensonify {
namespace {

// The patches of a shape one by one: those of a large mesh would take more memory than its world.
struct MeshPatches {
  const Mesh& mesh;
  std::size_t size() const { return mesh.triangles.size(); }
  TrianglePatch operator[](std::size_t i) const {
    const auto corner = [&](int k) { return to_vec3(mesh.vertices[mesh.triangles[i][k]]); };
    return {corner(0), corner(1), corner(2)};
  }
};

MeshPatches patches_of(const MeshShape& shape) { return {*shape.mesh}; }
std::vector<Patch> patches_of(const PlaneShape&) { return {}; }
template <class Body>
std::vector<Patch> patches_of(const Body& body) {
  return surface_patches(body);
}

double area_of(const TrianglePatch& patch) { return area_m2(patch); }
double area_of(const Patch& patch) {
  return std::visit([](const auto& p) { return area_m2(p); }, patch);
}

Vec3 place_on(const TrianglePatch& patch, double u, double v) {
  return point_of(patch, u, v).position_m;
}
Vec3 place_on(const Patch& patch, double u, double v) {
  return std::visit([&](const auto& p) { return point_of(p, u, v).position_m; }, patch);
}

bool is_inside(Vec3 p, const Sonar& sonar) {
  const double range = length(p);
  if (!in_range(range, sonar)) return false;
  const double elevation = std::asin(std::clamp(p.z / range, -1.0, 1.0));
  return std::abs(elevation) <= sonar.elevation_fan_rad / 2 &&
         sector_of(sonar, std::atan2(p.y, p.x)).has_value();
}

template <class Patches>
std::vector<Vec3> samples_of(const Patches& patches) {
  // The fraction of the golden ratio. Steps of this size, combined with steps of equal area, form a
  // lattice.
  constexpr double kGolden = 0.6180339887498949;
  double whole = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) whole += area_of(patches[i]);
  std::vector<Vec3> points;
  if (!(whole > 0)) return points;
  const double step = whole / kSurfaceSamples;
  double before = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const auto& patch = patches[i];
    const double area = area_of(patch);
    while (points.size() < std::size_t{kSurfaceSamples}) {
      const double at = (static_cast<double>(points.size()) + 0.5) * step - before;
      if (at >= area && i + 1 < patches.size()) break;
      const double v = kGolden * static_cast<double>(points.size() + 1);
      points.push_back(place_on(patch, std::min(at / area, 1.0), v - std::floor(v)));
    }
    before += area;
  }
  return points;
}

}  // namespace

std::vector<Vec3> surface_samples(const Shape& shape) {
  return std::visit([](const auto& s) { return samples_of(patches_of(s)); }, shape);
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
