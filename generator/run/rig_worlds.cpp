#include "run/rig_worlds.h"

#include "world/world.h"

namespace ensonify {

Result<Session> RigWorlds::session(Scenario scenario, std::uint32_t sequence) {
  const std::shared_ptr<Entry> entry = entries_.at({sequence, scenario.redraw});
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
  const std::shared_ptr<Entry> entry = entries_.at({sequence, session.scenario.redraw});
  const std::lock_guard lock(entry->mutex);
  if (!entry->world) entry->world = std::make_unique<const World>(session.world);
  if (!entry->tracer) entry->tracer = std::make_unique<const Tracer>(*entry->world);
  // A holder of the tracer also holds the world that it refers to.
  return {entry, entry->tracer.get()};
}

}  // namespace ensonify
