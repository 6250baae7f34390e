// From the world at one moment to all that a ping hears.
//
//   Moment  PingEchoes  ping_echoes
//   EchoCounts  count_echoes             how many there are
//   has_pictures  wants_hidden           what an output selection takes of a ping
//   moves  doppler_range  check_motion   what motion_within_ping does with a ping
#pragma once

#include <cstdint>
#include <vector>

#include "app/session.h"
#include "core/parallel.h"
#include "core/scatterers.h"
#include "trace/scatter.h"
#include "trace/tracer.h"

namespace ensonify {

// When a ping goes out: everything is where it is then.
struct Moment {
  const Session& session;
  const Fan& fan;
  const SurfaceScattering& scattering;
  const Tracer& tracer;
  std::uint32_t ping = 0;
  Pose sonar_in_world;
  bool with_hidden = false;       // what would be heard were the nearest surfaces transparent
  std::uint64_t speckle_key = 0;  // RandomKeys::speckle: where scatterers lie on surfaces
};

struct PingEchoes {
  ScattererList scatterers;
  std::vector<VolumeEcho> volumes;
  HiddenEchoes hidden;  // where asked for
};

PingEchoes ping_echoes(const Moment& moment, const Workers& workers);

// Scatterers of one ping: of its rays or of its surfaces; of mirrors, points, fish and bounces; and
// those that others hide.
struct EchoCounts {
  std::uint64_t surface = 0, coherent = 0, hidden = 0;
};

// Counts what ping_echoes puts together, by the same steps.
EchoCounts count_echoes(const Moment& moment, const Workers& workers);

// Polar, Cartesian or grey images.
bool has_pictures(const OutputSelection& output);
// Whether their labels tell what is hidden.
bool wants_hidden(const OutputSelection& output);

// The key is set, and the sonar or an object has more than one pose.
bool moves(const Session& session);

// min_doppler and max_doppler of SynthesisSetup: 2 v.u/c over the fan, more by 2 V/c of the fastest
// object, as some of the pings show them, and an eighth of it all to either side. 0 where nothing
// moves.
struct DopplerRange {
  double lowest = 0, highest = 0;
};
DopplerRange doppler_range(const Session& session);

// Error (usage): the pulse is one that the CPU backend cannot shift.
Status check_motion(const Session& session);

}  // namespace ensonify
