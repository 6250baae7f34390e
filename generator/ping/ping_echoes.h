// Collects all echoes of a ping from the world at one moment.
//
//   Moment  PingEchoes  ping_echoes
//   EchoCounts  count_echoes             the number of echoes
//   has_pictures  wants_hidden           the parts of a ping that an output selection needs
//   moves  doppler_range  check_motion   the effect of motion_within_ping on a ping
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/parallel.h"
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

// Groups of beams that transmit in turn (Sonar::transmit) have their own moments if anything moves
// (transmit_in_turn). The echoes of a beam cell are then those of its own group, and their
// positions are given in the sonar's frame at the ping's time. Echoes over several surfaces are
// heard if sound leaves and arrives in beam cells of one group.
PingEchoes ping_echoes(const Moment& moment, const Workers& workers);
bool transmit_in_turn(const Session& session);

// Scatterers of one ping: of its rays or of its surfaces; specular, point, fish and multipath
// echoes; and echoes that others hide.
struct EchoCounts {
  std::uint64_t surface = 0, coherent = 0, hidden = 0;
};

// Counts the echoes that ping_echoes collects, by the same steps.
EchoCounts count_echoes(const Moment& moment, const Workers& workers);

// Whether there are polar, Cartesian or 8-bit images.
bool has_pictures(const OutputSelection& output);
// Whether their labels include hidden parts.
bool wants_hidden(const OutputSelection& output);

// The key motion_within_ping is set, and the sonar or an object has more than one pose.
bool moves(const Session& session);

// min_doppler and max_doppler of SynthesisSetup: 2 v.u/c over the fan, extended by 2 V/c of the
// fastest object, at a sample of the pings, plus an eighth of the range on either side. 0 if
// nothing moves.
struct DopplerRange {
  double lowest = 0, highest = 0;
};
DopplerRange doppler_range(const Session& session);

// Error (usage): the CPU backend cannot apply Doppler to the pulse.
Status check_motion(const Session& session);

}  // namespace ensonify
