// The world at the moment when a ping, or a group of its beams, is transmitted, and its echoes.
//
//   Moment      what is traced, and when
//   PingEchoes  what comes back
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/ping.h"
#include "core/scatterers.h"
#include "ping/session.h"
#include "trace/refracted.h"
#include "trace/scatter.h"
#include "trace/tracer.h"

namespace ensonify {

// The time when a ping, or one of its groups of beams, is transmitted, and all poses at that time.
// `fan` has the cells of the group.
struct Moment {
  const Session& session;
  const Fan& fan;
  const SurfaceScattering& scattering;
  const Tracer& tracer;
  std::uint32_t ping = 0;
  Pose sonar_in_world;
  bool with_hidden = false;      // echoes as if the nearest surfaces were transparent
  std::uint64_t places_key = 0;  // of scatterers on surfaces, and of directions of bounces
  bool with_front = false;       // what the rays meet first
  double volume_step_rad = 0;    // of elevation, for echoes of volumes by steps; 0: none
  double after_s = 0;            // from the ping's time
  // Of a group: what its rays meet, and those of all groups, each at its own time.
  const FanHits* traced = nullptr;
  std::span<const Hit> all_hits = {};

  double time_s() const { return session.ping_times_s[ping] + after_s; }
};

struct PingEchoes {
  ScattererList scatterers;
  std::vector<VolumeEcho> volumes;
  HiddenEchoes hidden;             // if requested
  std::optional<FrontView> front;  // ... without classes
  std::vector<ElevationEcho> volume_elevation = {};
};

}  // namespace ensonify
