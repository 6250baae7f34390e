#include "app/world_cache.h"

#include <algorithm>

#include "app/memory.h"

namespace ensonify {

std::string world_key(const Scenario& scenario) {
  // As drawn for sequence 0, not as a distribution.
  Scenario part;
  part.scattering = scenario.scattering;
  part.scattering.speckle = SpeckleMode::per_ping;
  part.materials = scenario.materials;
  part.objects = scenario.objects;
  part.point_targets = scenario.point_targets;
  part.volumes = scenario.volumes;
  part.has_draws = scenario.has_draws;
  // Its draws are those of terrain, plumes, fish, places and jitters.
  if (varies_by_sequence(part)) part.seed = scenario.seed;
  std::string key = to_yaml(part, [](const std::filesystem::path& file) { return file.string(); });
  // Numbers of classes follow from all that the scenario could draw.
  for (const std::string& name : scenario.class_names) key += name + "\n";
  return key;
}

Result<BuiltWorld> WorldCache::world(
    const std::string& key, const Scenario& scenario,
    const std::function<Result<BuiltWorld>(const Scenario&)>& build) {
  std::promise<Result<BuiltWorld>> promise;
  std::shared_future<Result<BuiltWorld>> world;
  std::uint64_t expected_bytes = 0;
  bool mine = false;
  {
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[key];
    mine = !entry.world.valid();
    if (mine) entry.world = promise.get_future().share();
    world = entry.world;
    expected_bytes = largest_bytes_;
  }
  if (!mine) return world.get();
  try {
    MemoryGate::Hold hold = gate_.hold(MemoryGate::What::world, expected_bytes);
    Result<BuiltWorld> built = build(scenario);
    const std::uint64_t bytes = built ? world_bytes(*built->world) : 0;
    gate_.resize(hold, bytes);
    {
      const std::lock_guard lock(mutex_);
      largest_bytes_ = std::max(largest_bytes_, bytes);
      const auto entry = entries_.find(key);
      if (entry != entries_.end()) entry->second.hold = std::move(hold);
    }
    promise.set_value(std::move(built));
  } catch (...) {
    promise.set_exception(std::current_exception());
  }
  return world.get();
}

void WorldCache::forget(const std::string& key) {
  Entry gone;
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) return;
  gone = std::move(entry->second);
  entries_.erase(entry);
}

}  // namespace ensonify
