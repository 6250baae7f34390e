// What motion_within_ping does with a ping.
//
//   moves        whether anything of a session does
//   max_doppler  how far shifts reach
//   move         what is heard, from where it is heard
#pragma once

#include "app/ping_echoes.h"
#include "core/error.h"

namespace ensonify {

// The key is set, and the sonar or an object has more than one pose.
bool moves(const Session& session);

// SynthesisSetup::max_doppler: 2 (v + V)/c of the fastest sonar and the fastest object that some of
// the pings show, and a quarter more. 0 where nothing moves.
double max_doppler(const Session& session);

// Error (usage): the pulse is one that the CPU backend cannot shift.
Status check_motion(const Session& session);

// Scatterers and hidden echoes by move_echoes; volumes stay. Nothing where nothing moves.
void move(const Moment& moment, const Workers& workers, PingEchoes& echoes);

}  // namespace ensonify
