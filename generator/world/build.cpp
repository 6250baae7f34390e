#include <algorithm>
#include <map>
#include <tuple>

#include "world/world.h"

namespace ensonify {
namespace {

using MeshKey = std::tuple<std::string, double, bool>;
using MeshCache = std::map<MeshKey, std::shared_ptr<const Mesh>>;

Result<Shape> shape_of(const ShapeSpec& spec, MeshCache& meshes) {
  if (const auto* box = std::get_if<BoxSpec>(&spec)) {
    return Shape(
        BoxShape{{box->size_m[0] / 2, box->size_m[1] / 2, box->size_m[2] / 2}, box->inside});
  }
  if (const auto* sphere = std::get_if<SphereSpec>(&spec)) {
    return Shape(SphereShape{sphere->radius_m, sphere->inside});
  }
  if (const auto* cylinder = std::get_if<CylinderSpec>(&spec)) {
    return Shape(CylinderShape{cylinder->radius_m, cylinder->height_m / 2});
  }
  if (const auto* mesh = std::get_if<MeshSpec>(&spec)) {
    auto& cached = meshes[{mesh->file.string(), mesh->scale, mesh->smooth_normals}];
    if (!cached) {
      Result<Mesh> loaded = load_mesh(mesh->file, mesh->scale,
                                      mesh->smooth_normals ? Normals::smooth : Normals::face);
      if (!loaded) return loaded.error();
      cached = std::make_shared<const Mesh>(std::move(*loaded));
    }
    return Shape(MeshShape{cached});
  }
  return Shape(PlaneShape{});
}

std::uint8_t class_id(std::vector<std::string>& classes, const std::string& name) {
  const auto found = std::find(classes.begin(), classes.end(), name);
  if (found != classes.end()) return static_cast<std::uint8_t>(found - classes.begin() + 1);
  classes.push_back(name);
  return static_cast<std::uint8_t>(classes.size());
}

Instance& add_instance(World& world, const std::string& name, const std::string& class_name) {
  Instance instance;
  instance.id = static_cast<std::uint16_t>(world.instances.size() + 1);
  instance.name = name;
  instance.class_name = class_name;
  instance.class_id = class_id(world.classes, class_name);
  world.instances.push_back(instance);
  return world.instances.back();
}

}  // namespace

Result<World> build_world(const Scenario& scenario) {
  std::map<std::string, Material> materials;
  for (const MaterialSpec& spec : scenario.materials) {
    materials[spec.name] = material_of(spec, scenario.scattering);
  }
  World world;
  MeshCache meshes;
  std::string faults;
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const ObjectSpec& spec = scenario.objects[i];
    Result<Shape> shape = shape_of(spec.shape, meshes);
    if (!shape) {
      faults += (faults.empty() ? "" : "\n") + ("objects." + std::to_string(i)) +
                ".shape.mesh.file: " + shape.error().message;
      continue;
    }
    Instance& instance = add_instance(world, spec.name, spec.class_name);
    instance.material = spec.material;
    instance.scattering = materials.at(spec.material);
    world.objects.push_back(
        {instance.id, std::move(*shape), pose_of(spec.pose), instance.scattering});
  }
  if (!faults.empty()) return Error{ErrorKind::usage, faults};
  for (const PointTargetSpec& spec : scenario.point_targets) {
    Instance& instance = add_instance(world, spec.name, spec.class_name);
    instance.kind = InstanceKind::point_target;
    instance.target_strength_db = spec.target_strength_db;
    world.point_targets.push_back({instance.id,
                                   {spec.position_m[0], spec.position_m[1], spec.position_m[2]},
                                   spec.target_strength_db});
  }
  return world;
}

}  // namespace ensonify
