#include <utility>

#include "world/world.h"

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

}  // namespace ensonify
