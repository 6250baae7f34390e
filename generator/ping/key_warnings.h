// Warnings about keys that imply one quantity and disagree, or that cannot all be true.
//
//   key_warnings      the water, the beams, the times of paths and pings
//   fan_warnings      what the fan of rays leaves out of the pattern in elevation
//   check_ping_rate   an error: pings that overlap while everything moves
#pragma once

#include <string>
#include <vector>

#include "core/parallel.h"
#include "ping/session.h"
#include "trace/tracer.h"

namespace ensonify {

// One line each, without line ends:
//   sound speeds that differ by more than 2 % from that of the water, temperatures and salinities
//   by more than 1, densities by more than 1 %, a sound speed more than 1 % outside the profile;
//   beam cells more than twice as wide as their beams, arrays whose beams are more than 10 % wider
//   or narrower than stated, planes that are not at the bottom of multipath;
//   paths of objects that end before the first ping or start after the last;
//   pings, or groups of beams, that are sent before the echoes of the ones before have arrived.
std::vector<std::string> key_warnings(const Session& session);

// A warning if the fan leaves out surfaces at the first ping where the pattern exceeds -20 dB, with
// the fan that has them. `tracer` is that of the session's
// world.
std::vector<std::string> fan_warnings(const Session& session, const Tracer& tracer,
                                      const Workers& workers);

// Error (usage) if motion_within_ping is true and a ping is sent before the echoes of the one
// before it have arrived.
Status check_ping_rate(const Session& session);

// Error (usage) if groups of beams that transmit in turn need more time than there is between
// pings.
Status check_groups(const Session& session);

}  // namespace ensonify
