// The cost of generating a data set, estimated before anything is written.
//
//   pings_under_way  work_items  sequences_under_way   how work is divided
//   PingSize  ping_size  layer_count  channel_samples  volume_elevation_count
//   Cost  estimate_cost  cpu_memory  estimate_files  run_peak_bytes  bytes_text  seconds_text
//   run_cost                                           for a run of a sweep
#pragma once

#include <cstdint>
#include <string>

#include "app/memory.h"
#include "app/session.h"
#include "app/tables.h"
#include "sweep/expand.h"
#include "synthesis/backend.h"

namespace ensonify {

struct Cost {
  std::uint64_t pings = 0;
  std::uint64_t files = 0;       // exact
  std::uint64_t disk_bytes = 0;  // compressed parts and tables estimated from typical images
  std::uint64_t peak_bytes = 0;  // memory of the process, with all pings in progress at once
};

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

// The size of one ping. Cartesian pixels are counted only if they are requested.
struct PingSize {
  std::uint64_t rays = 0, pixels = 0, cartesian_pixels = 0;
};
PingSize ping_size(const Session& session);

// Layers of each ping in sequence 0.
std::uint64_t layer_count(const Session& session);

// Number of values of output.channels in a ping.
std::uint64_t channel_samples(const Session& session);

// The most entries of volumes in a ping's echoes over elevation.
std::uint64_t volume_elevation_count(const Session& session);

// `loaded` is the process's memory before it makes tables, of which `synthesis` is a part.
Cost estimate_cost(const Session& session, int threads, const ResidentMemory& loaded,
                   const SynthesisMemory& synthesis);

// The memory of the backend `cpu`, which plans assume for each machine.
SynthesisMemory cpu_memory(const Session& session, const Numerics& numerics);

// Memory of one of several runs in a process, in addition to what it has loaded. With `exact`, a
// few pings are traced; otherwise it is an upper bound that may be far too high.
std::uint64_t run_peak_bytes(const Session& session, int threads, bool exact,
                             const SynthesisMemory& synthesis);

// Estimates only pings, files and bytes, from the `echoes` of a ping. Needs the world only for the
// size of its distance field.
Cost estimate_files(const Session& session, std::uint64_t echoes);

// "12 MB", "2.5 h"
std::string bytes_text(std::uint64_t bytes);
std::string seconds_text(double seconds);

// The cost of a run of a sweep, from its scenario alone: no world is built and nothing is traced,
// so that thousands of runs are estimated in a second. The same on every machine. Errors (usage):
// those of prepare_without_world.
Result<RunCost> run_cost(Scenario scenario);

}  // namespace ensonify
