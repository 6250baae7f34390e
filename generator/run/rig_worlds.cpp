#include "run/rig_worlds.h"

#include <algorithm>

#include "world/world.h"

namespace ensonify {

Result<Session> RigWorlds::session(Scenario scenario, std::uint32_t sequence) {
  const std::shared_ptr<Entry> entry = entry_of({sequence, scenario.redraw});
  const std::lock_guard lock(entry->mutex);
  if (!entry->world) {
    Result<World> world = build_world(scenario, sequence, &shared_.meshes);
    if (!world) return world.error();
    give_back_import(*world);
    entry->world = std::make_unique<const World>(std::move(*world));
  }
  Result<Session> session = prepare_in_world(std::move(scenario), sequence, World(*entry->world),
                                             entry->tiles, &shared_.ringing);
  if (session) entry->tiles = session->surface_tiles;
  return session;
}

std::shared_ptr<const Tracer> RigWorlds::tracer(const Session& session, std::uint32_t sequence) {
  const std::shared_ptr<Entry> entry = entry_of({sequence, session.scenario.redraw});
  const std::lock_guard lock(entry->mutex);
  if (!entry->world) entry->world = std::make_unique<const World>(session.world);
  if (!entry->tracer) entry->tracer = std::make_unique<const Tracer>(*entry->world);
  // A holder of the tracer also holds the world that it refers to.
  return {entry, entry->tracer.get()};
}

std::shared_ptr<RigWorlds::Entry> RigWorlds::entry_of(Key key) {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [](const auto& entry) { return entry.second.expired(); });
  std::shared_ptr<Entry> found = entries_[key].lock();
  if (!found) {
    found = std::make_shared<Entry>();
    entries_[key] = found;
  }
  std::erase(last_, found);
  last_.push_back(found);
  if (last_.size() > kKept) last_.pop_front();
  return found;
}

}  // namespace ensonify
