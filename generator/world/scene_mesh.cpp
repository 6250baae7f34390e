#include "world/scene_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

namespace ensonify {
namespace {

using Corners = std::array<std::uint32_t, 3>;

// Of a full circle. On a sphere, the distances of both directions add up.
constexpr std::uint32_t kMeridians = 100;
constexpr std::uint32_t kParallels = kMeridians / 2;

void turn_inside_out(Mesh& mesh) {
  for (Corners& t : mesh.triangles) std::swap(t[1], t[2]);
}

std::array<double, 2> on_circle(std::uint32_t meridian) {
  const double angle = 2 * std::numbers::pi * meridian / kMeridians;
  return {std::cos(angle), std::sin(angle)};
}

std::uint32_t next_meridian(std::uint32_t meridian) { return (meridian + 1) % kMeridians; }

// Two triangles, counterclockwise as the corners.
void add_quad(Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

// Equal for shapes of equal size, which share a mesh.
using ShapeKey = std::tuple<int, double, double, double, const void*>;

ShapeKey key_of(const BoxShape& box) {
  const Vec3 h = box.half_size_m;
  return {box.inside ? 1 : 0, h.x, h.y, h.z, nullptr};
}
ShapeKey key_of(const SphereShape& sphere) {
  return {sphere.inside ? 3 : 2, sphere.radius_m, 0, 0, nullptr};
}
ShapeKey key_of(const CylinderShape& cylinder) {
  return {4, cylinder.radius_m, cylinder.half_height_m, 0, nullptr};
}
ShapeKey key_of(const MeshShape& shape) { return {5, 0, 0, 0, shape.mesh.get()}; }
// Planes are cut each by itself.
ShapeKey key_of(const PlaneShape& plane) { return {6, 0, 0, 0, &plane}; }

struct MeshCount {
  std::uint64_t vertices = 0, triangles = 0;
  bool normals = false;
};

MeshCount count_of(const BoxShape&) { return {8, 12}; }
MeshCount count_of(const SphereShape&) {
  return {(kParallels - 1) * kMeridians + 2, 2 * (kParallels - 1) * kMeridians};
}
MeshCount count_of(const CylinderShape&) { return {2 * kMeridians + 2, 4 * kMeridians}; }
MeshCount count_of(const PlaneShape&) { return {4, 2}; }
MeshCount count_of(const MeshShape& shape) {
  return {shape.mesh->vertices.size(), shape.mesh->triangles.size(), !shape.mesh->normals.empty()};
}

}  // namespace

Mesh tessellated(const BoxShape& box) {
  Mesh mesh;
  const Vec3 h = box.half_size_m;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(
        to_floats({i & 1 ? h.x : -h.x, i & 2 ? h.y : -h.y, i & 4 ? h.z : -h.z}));
  }
  for (const auto& [a, b, c, d] : {std::array<std::uint32_t, 4>{0, 4, 6, 2},
                                   {1, 3, 7, 5},
                                   {0, 1, 5, 4},
                                   {2, 6, 7, 3},
                                   {0, 2, 3, 1},
                                   {4, 5, 7, 6}}) {
    add_quad(mesh, a, b, c, d);
  }
  if (box.inside) turn_inside_out(mesh);
  return mesh;
}

Mesh tessellated(const SphereShape& sphere) {
  Mesh mesh;
  const double r = sphere.radius_m;
  for (std::uint32_t p = 1; p < kParallels; ++p) {
    const double colatitude = std::numbers::pi * p / kParallels;
    for (std::uint32_t m = 0; m < kMeridians; ++m) {
      const auto [x, y] = on_circle(m);
      const double across = r * std::sin(colatitude);
      mesh.vertices.push_back(to_floats({across * x, across * y, r * std::cos(colatitude)}));
    }
  }
  const auto top = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(to_floats({0, 0, r}));
  mesh.vertices.push_back(to_floats({0, 0, -r}));
  const std::uint32_t last = (kParallels - 2) * kMeridians;
  for (std::uint32_t m = 0; m < kMeridians; ++m) {
    const std::uint32_t n = next_meridian(m);
    mesh.triangles.push_back({top, m, n});
    for (std::uint32_t row = 0; row < last; row += kMeridians) {
      add_quad(mesh, row + m, row + kMeridians + m, row + kMeridians + n, row + n);
    }
    mesh.triangles.push_back({top + 1, last + n, last + m});
  }
  if (sphere.inside) turn_inside_out(mesh);
  return mesh;
}

Mesh tessellated(const CylinderShape& cylinder) {
  Mesh mesh;
  const auto [r, h] = std::pair(cylinder.radius_m, cylinder.half_height_m);
  for (const double z : {-h, h}) {
    for (std::uint32_t m = 0; m < kMeridians; ++m) {
      const auto [x, y] = on_circle(m);
      mesh.vertices.push_back(to_floats({r * x, r * y, z}));
    }
  }
  constexpr std::uint32_t kLow = 2 * kMeridians, kHigh = kLow + 1;
  mesh.vertices.push_back(to_floats({0, 0, -h}));
  mesh.vertices.push_back(to_floats({0, 0, h}));
  for (std::uint32_t m = 0; m < kMeridians; ++m) {
    const std::uint32_t n = next_meridian(m);
    add_quad(mesh, m, n, kMeridians + n, kMeridians + m);
    mesh.triangles.push_back({kLow, n, m});
    mesh.triangles.push_back({kHigh, kMeridians + m, kMeridians + n});
  }
  return mesh;
}

std::optional<Mesh> tessellated(const PlaneShape&, const Pose& pose, const SceneReach& reach) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double west = kNone, east = -kNone, south = kNone, north = -kNone;
  for (const Vec3& sonar_m : reach.sonars_m) {
    const Vec3 p = inverse_transform_point(pose, sonar_m);
    const double squared = (reach.range_m - p.z) * (reach.range_m + p.z);
    if (!(squared > 0)) continue;
    const double radius = std::sqrt(squared);
    west = std::min(west, p.x - radius);
    east = std::max(east, p.x + radius);
    south = std::min(south, p.y - radius);
    north = std::max(north, p.y + radius);
  }
  if (!(west < east)) return std::nullopt;
  Mesh mesh;
  for (const auto& [x, y] : {std::pair(west, south), {east, south}, {east, north}, {west, north}}) {
    mesh.vertices.push_back(to_floats({x, y, 0}));
  }
  add_quad(mesh, 0, 1, 2, 3);
  return mesh;
}

std::vector<SceneObject> scene_objects(const World& world, std::span<const Pose> object_in_world,
                                       const SceneReach& reach) {
  ENSONIFY_ASSERT(object_in_world.size() == world.objects.size());
  std::map<ShapeKey, std::shared_ptr<const Mesh>> shared;
  std::vector<SceneObject> objects;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const Pose& pose = object_in_world[i];
    std::shared_ptr<const Mesh> mesh = std::visit(
        [&](const auto& shape) -> std::shared_ptr<const Mesh> {
          using Kind = std::decay_t<decltype(shape)>;
          if constexpr (std::is_same_v<Kind, MeshShape>) {
            return shape.mesh;
          } else if constexpr (std::is_same_v<Kind, PlaneShape>) {
            auto cut = tessellated(shape, pose, reach);
            return cut ? std::make_shared<const Mesh>(std::move(*cut)) : nullptr;
          } else {
            auto& one = shared[key_of(shape)];
            if (!one) one = std::make_shared<const Mesh>(tessellated(shape));
            return one;
          }
        },
        world.objects[i].shape);
    if (mesh && !mesh->triangles.empty()) objects.push_back({&world.objects[i], mesh, pose});
  }
  return objects;
}

SceneSize scene_size(const World& world) {
  constexpr std::uint64_t kPlyVertex = 3 * 8, kPlyFace = 1 + 3 * 4 + 2 + 1;
  constexpr std::uint64_t kGlbVector = 3 * 4;
  SceneSize size;
  std::set<ShapeKey> counted;
  for (const WorldObject& object : world.objects) {
    const auto [key, count] = std::visit(
        [](const auto& shape) { return std::pair(key_of(shape), count_of(shape)); }, object.shape);
    size.vertices += count.vertices;
    size.ply_bytes += count.vertices * kPlyVertex + count.triangles * kPlyFace;
    if (!counted.insert(key).second) continue;
    size.glb_bytes += (count.vertices * (1 + count.normals) + count.triangles) * kGlbVector;
    const bool is_mesh = std::holds_alternative<MeshShape>(object.shape);
    if (!is_mesh) size.made_bytes += (count.vertices + count.triangles) * sizeof(Corners);
  }
  return size;
}

Status scene_fits(const World& world) {
  const SceneSize size = scene_size(world);
  constexpr std::uint64_t kMostVertices = std::numeric_limits<std::int32_t>::max();
  constexpr std::uint64_t kMostBytes = 4'000'000'000;
  if (size.vertices <= kMostVertices && size.glb_bytes <= kMostBytes) return {};
  return Error{ErrorKind::usage,
               fmt::format("the meshes have {} vertices and {} bytes; expected {} vertices and {} "
                           "bytes at most",
                           size.vertices, size.glb_bytes, kMostVertices, kMostBytes)};
}

}  // namespace ensonify
