// Collects all echoes of a ping from the world at one moment.
//
//   ping_echoes  transmit_in_turn
//   EchoCounts  count_echoes             the number of echoes
//   has_pictures  wants_hidden           the parts of a ping that an output selection needs
//   moves  doppler_range  check_motion   the effect of motion_within_ping on a ping
#pragma once

#include <cstdint>

#include "core/error.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "ping/moment.h"
#include "ping/session.h"

namespace ensonify {

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
