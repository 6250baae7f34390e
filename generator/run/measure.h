// Makes at most two pings of a run in memory, as `generate` makes them, and extrapolates to the
// whole run.
//
//   RunTime  time_now          processor time and time by the clock
//   MeasureJob                 the work
//   Measured  measure_pings    times and sizes of its pings, and the objects in them
//   time_of                    the time of the run
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/error.h"
#include "ping/object_looks.h"
#include "ping/tables.h"
#include "run/sequence_worlds.h"

namespace ensonify {

// All sequences and pings of the scenario.
struct MeasureJob {
  const SequenceWorlds& worlds;  // with its first tracer
  const Numerics& numerics;
  int threads = 1;
  // Where files without a name measure the time of writing, and vanish; empty: nothing is written.
  std::filesystem::path disk = {};
};

// The objects at ping 0 of a sequence.
struct LookedSequence {
  std::uint32_t sequence = 0;
  ReadyWorld world;
  std::vector<ObjectLook> objects;
};

struct RunTime {
  double wall_s = 0, core_s = 0;
  friend RunTime operator-(const RunTime& a, const RunTime& b) {
    return {a.wall_s - b.wall_s, a.core_s - b.core_s};
  }
  friend RunTime operator+(const RunTime& a, const RunTime& b) {
    return {a.wall_s + b.wall_s, a.core_s + b.core_s};
  }
};

// Wall clock time, and processor time of all threads of this process.
RunTime time_now();

// Means over the measured pings. Seconds are those of one core, except where they are by the clock.
struct Measured {
  std::uint64_t pings = 0, sequences = 0;  // how many were measured
  std::array<double, 2> limits_db = {};    // of 8-bit images
  std::vector<LookedSequence> looked;      // those sequences
  RunTime probe;                           // for limits: what is not used again
  double world_s = 0;                      // for a sequence that has a world of its own
  double prepare_s = 0;                    // for any sequence, before its pings
  double ping_s = 0;                       // for a ping
  double alone_s = 0;                      // ... by the clock, if two pings share the threads
  double store_s = 0;                      // for writing the files of a ping, by the clock
  double finish_s = 0;  // for a ping, when its sequence is finished: arrays, tables, manifest
  double list_s = 0;    // ... and when the data set is finished, by one thread
  // Bytes per ping, as in dataset/footprint.h, and per sequence.
  double files = 0, piece = 0, sequence_lines = 0, dataset_lines = 0, record = 0;
  double sequence_bytes = 0;
};

// Measures ping 0 of the sequences that give the limits of 8-bit images (run/display_limits.h) or,
// if all sequences share one world, the first and the last ping. Errors: those of
// for_probed_sequences, make_pipeline and encode_ping. Throws DeviceFailure.
Result<Measured> measure_pings(const MeasureJob& job);

// From the first ping to the end of the last file, with `threads`.
RunTime time_of(const Measured& measured, std::uint32_t sequences, std::uint32_t pings, bool vary,
                int threads);

}  // namespace ensonify
