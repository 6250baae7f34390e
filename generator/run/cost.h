// How much work a data set is, from its scenario, before anything is written.
//
//   pings_under_way  work_items  sequences_under_way   how work is divided
//   PingSize  ping_size  count_echoes  most_echoes     the size of a ping
//   EchoProbe  probe_echoes                            ... from a few of its rays
//   encoded_bytes  estimated_bytes  estimate_cost  run_cost   files, bytes and work
//   bytes_text  seconds_text
#pragma once

#include <cstdint>
#include <string>

#include "ping/ping_echoes.h"
#include "ping/session.h"
#include "sweep/expand.h"
#include "trace/tracer.h"

namespace ensonify {

// The number of pings in progress in `generate`: one computed by each thread, and some whose files
// are being written.
int pings_under_way(int threads, std::uint64_t pings);

// The units in which the pings of a sequence are distributed: single pings, or blocks of an
// ensemble.
std::uint32_t work_items(std::uint32_t pings, const OutputSelection& output);

// The number of sequences of `pings` each that gives enough pings in progress. It is at least two
// if each sequence has a world of its own, so that one world is built while the pings of another
// are computed.
int sequences_under_way(int threads, std::uint64_t pings, std::uint64_t sequences, bool vary);

// The size of one ping. What is not requested is 0.
struct PingSize {
  std::uint64_t rays = 0, pixels = 0, cartesian_pixels = 0;
  std::uint64_t layers = 0;             // of sequence 0
  std::uint64_t channel_samples = 0;    // of output.channels
  std::uint64_t volume_elevations = 0;  // the most entries of volumes in the echoes over elevation
};
PingSize ping_size(const Session& session);

// The largest count at the first, middle and last ping, which are traced, since no formula predicts
// how many rays hit something. `tracer`: of the session's world.
EchoCounts count_echoes(const Session& session, const Tracer& tracer);

// An upper bound for all pings, found without tracing; it is often far too high.
EchoCounts most_echoes(const Session& session);

// From some of the rays of ping 0, in a fraction of a second.
struct EchoProbe {
  EchoCounts counts;  // one for each ray that meets a surface
  // Of adaptive refinement, which replace counts.surface if they are more: the first pieces, and
  // with those at edges. Of scatterers that are fixed on surfaces there may be none.
  std::uint64_t least_pieces = 0, likely_pieces = 0;
};
EchoProbe probe_echoes(const Session& session, const Tracer& tracer);

// The files of one ping with this number of echoes, as typical images have them.
std::uint64_t encoded_bytes(const Session& session, std::uint64_t echoes);

// The bytes of a part of a data set, from the table of outputs.
double estimated_bytes(const Session& session, std::uint64_t echoes, std::uint64_t pings,
                       std::uint64_t sequences);

// From the number of echoes of a ping. Needs the world only for the size of scene files.
Cost estimate_cost(const Session& session, std::uint64_t echoes);

// "12 MB", "2.5 h"
std::string bytes_text(std::uint64_t bytes);
std::string seconds_text(double seconds);

// The cost of a run of a sweep, from its scenario alone: no world is built and nothing is traced,
// so that thousands of runs are estimated in a second. The same on every machine. Errors (usage):
// those of prepare_without_world.
Result<Cost> run_cost(Scenario scenario);

}  // namespace ensonify
