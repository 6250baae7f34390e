#include "run/world_memory.h"

#include <algorithm>
#include <complex>
#include <set>
#include <utility>
#include <variant>

namespace ensonify {
namespace {

// Embree's hierarchy while it is built, and its copy of the vertices.
constexpr std::uint64_t kHierarchyBytesPerTriangle = 95;
constexpr std::uint64_t kHierarchyBytesPerObject = 1200;  // in two scenes
// Output for each object, for all pings together.
constexpr std::uint64_t kTextBytesPerObject = 2000;

enum class Meshes { all, own };  // own: not those of files, which all worlds share

// Loaded data of a world: meshes, images and densities, each counted once.
std::uint64_t loaded_bytes(const World& world, Meshes meshes) {
  std::set<const void*> counted;
  std::uint64_t sum = 0;
  for (const WorldObject& object : world.objects) {
    const auto* shape = std::get_if<MeshShape>(&object.shape);
    if (shape == nullptr || (meshes == Meshes::own && !shape->ground)) continue;
    if (shape->image && counted.insert(shape->image.get()).second) sum += shape->image->bytes();
    if (!counted.insert(shape->mesh.get()).second) continue;
    const Mesh& mesh = *shape->mesh;
    sum += (mesh.vertices.size() + mesh.normals.size() + mesh.colors.size()) * sizeof(float[3]) +
           mesh.triangles.size() * sizeof(std::uint32_t[3]) +
           mesh.reflectivity.size() * sizeof(float) + mesh.uv.size() * sizeof(float[2]) +
           mesh.part.size();
  }
  for (const Volume& volume : world.volumes) {
    if (volume.patches) sum += volume.patches->bytes();
    const auto* grid = std::get_if<std::shared_ptr<const DensityGrid>>(&volume.density);
    if (grid != nullptr && counted.insert(grid->get()).second) sum += (*grid)->bytes();
  }
  return sum;
}

}  // namespace

std::uint64_t hierarchy_bytes(const World& world) {
  std::set<const Mesh*> meshes;
  std::uint64_t sum = world.objects.size() * (kHierarchyBytesPerObject + kTextBytesPerObject);
  for (const WorldObject& object : world.objects) {
    for (const MaterialFields& fields : object.fields) {
      for (const auto& field : {fields.texture, fields.growth, fields.growth_texture}) {
        if (field) sum += field->bytes();
      }
    }
    const auto* shape = std::get_if<MeshShape>(&object.shape);
    if (shape == nullptr || !meshes.insert(shape->mesh.get()).second) continue;
    sum += shape->mesh->triangles.size() * (kHierarchyBytesPerTriangle + sizeof(std::uint32_t[3])) +
           shape->mesh->vertices.size() * sizeof(float[3]);
  }
  return sum;
}

std::uint64_t unshared_bytes(const World& world) { return loaded_bytes(world, Meshes::own); }

std::uint64_t world_bytes(const World& world) {
  return loaded_bytes(world, Meshes::all) + hierarchy_bytes(world);
}

double terrain_bytes(const HeightfieldSpec& spec) {
  if (!spec.file.empty()) return 0;
  const auto [columns, rows] = vertices_along(spec);
  const double vertices = double(columns) * rows;
  const double normals = spec.smooth_normals ? sizeof(float[3]) : 0;
  const double mesh = vertices * (sizeof(float[3]) + normals + 2 * sizeof(std::uint32_t[3]));
  // The hierarchy has a copy of the triangles and vertices. Before, heights are sums of waves.
  const double traced =
      vertices * (2 * (kHierarchyBytesPerTriangle + sizeof(std::uint32_t[3])) + sizeof(float[3]));
  double waves = 0;
  if (spec.roughness) {
    const auto [period_x, period_y] = roughness_period(spec);
    waves = double(period_x) * double(period_y) * sizeof(std::complex<double>);
  }
  return std::max(mesh + traced, waves + vertices * sizeof(double));
}

}  // namespace ensonify
