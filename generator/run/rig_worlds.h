// The worlds that the instruments of a rig share: each is built and prepared for tracing once.
//
//   RigWorlds
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

#include "core/recent_entries.h"
#include "ping/prepare_session.h"
#include "ping/session.h"
#include "trace/tracer.h"

namespace ensonify {

// Worlds in use, and the last ones. May be used from several threads at once.
class RigWorlds {
 public:
  // prepare_session for an instrument. The first one builds the world and cuts its surfaces.
  Result<Session> session(Scenario scenario, std::uint32_t sequence);
  // Of the world of that session.
  std::shared_ptr<const Tracer> tracer(const Session& session, std::uint32_t sequence);

 private:
  struct Entry {
    std::mutex mutex;
    std::unique_ptr<const World> world;
    std::shared_ptr<const SurfaceTiles> tiles;  // with speckle: surface
    std::unique_ptr<const Tracer> tracer;
  };
  // By sequence and redraw. Sequences from which the limits of 8-bit images come are asked for by
  // all instruments.
  using Key = std::pair<std::uint32_t, std::uint32_t>;

  SharedWorlds shared_;
  RecentEntries<Key, Entry> entries_;
};

}  // namespace ensonify
