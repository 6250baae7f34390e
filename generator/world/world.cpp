#include "world/world.h"

#include <algorithm>
#include <utility>

#include "scenario/scenario.h"

namespace ensonify {

Result<std::shared_ptr<const Mesh>> MeshLibrary::mesh(const std::string& key,
                                                      const std::function<Result<Mesh>()>& load) {
  // Drops meshes that no world uses any more, because each sampled scale is used only once.
  constexpr std::size_t kKept = 64;
  const std::lock_guard lock(mutex_);
  const auto found = meshes_.find(key);
  if (found != meshes_.end()) return found->second;
  Result<Mesh> loaded = load();
  if (!loaded) return loaded.error();
  if (meshes_.size() >= kKept) {
    std::erase_if(meshes_, [](const auto& entry) { return entry.second.use_count() == 1; });
  }
  auto mesh = std::make_shared<const Mesh>(std::move(*loaded));
  meshes_.emplace(key, mesh);
  return mesh;
}

Result<std::shared_ptr<const ReflectivityImage>> MeshLibrary::image(
    const std::filesystem::path& file) {
  constexpr std::size_t kKept = 16;
  const std::lock_guard lock(mutex_);
  const auto found = images_.find(file.string());
  if (found != images_.end()) return found->second;
  Result<ReflectivityImage> loaded = load_reflectivity_image(file);
  if (!loaded) return loaded.error();
  if (images_.size() >= kKept) {
    std::erase_if(images_, [](const auto& entry) { return entry.second.use_count() == 1; });
  }
  auto image = std::make_shared<const ReflectivityImage>(std::move(*loaded));
  images_.emplace(file.string(), image);
  return image;
}

bool is_room(const Shape& shape) {
  const auto* box = std::get_if<BoxShape>(&shape);
  const auto* sphere = std::get_if<SphereShape>(&shape);
  return (box != nullptr && box->inside) || (sphere != nullptr && sphere->inside);
}

Pose object_pose(const WorldObject& object, double time_s) {
  return object.path ? pose_at(*object.path, time_s) : object.pose;
}

std::vector<FlatReflector> flat_reflectors(const Scenario& scenario) {
  std::vector<FlatReflector> found;
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const ObjectSpec& object = scenario.objects[i];
    const auto* box = std::get_if<BoxSpec>(&object.shape);
    if (box == nullptr && !std::holds_alternative<PlaneSpec>(object.shape)) continue;
    const auto material =
        std::ranges::find(scenario.materials, object.material, &MaterialSpec::name);
    if (material == scenario.materials.end()) continue;
    const auto* kirchhoff = std::get_if<KirchhoffSpec>(&material->coherent);
    if (kirchhoff == nullptr) continue;
    found.push_back({object.name, i, box != nullptr, box != nullptr && box->inside,
                     kirchhoff->reflection, kirchhoff->roughness_rms_m});
  }
  return found;
}

}  // namespace ensonify
