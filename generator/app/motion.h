// What motion_within_ping does with a ping.
//
//   moves        whether anything of a session does
//   doppler_range  between which shifts lie
//   move         what is heard, from where it is heard
#pragma once

#include "app/ping_echoes.h"
#include "core/error.h"

namespace ensonify {

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

// Scatterers and hidden echoes by move_echoes; volumes stay. Nothing where nothing moves.
void move(const Moment& moment, const Workers& workers, PingEchoes& echoes);

}  // namespace ensonify
