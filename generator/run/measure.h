// Makes a few pings of a run in memory, as `generate` makes them, and extrapolates to the whole
// run.
//
//   MeasureJob                     the work
//   Measured  measure_pings        times and sizes of a few of its pings
//   spread_order                   the selection of these pings
//   RunTime  time_now  time_of     the time of the run
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "core/error.h"
#include "ping/pipeline.h"
#include "ping/tables.h"
#include "run/sequence_worlds.h"

namespace ensonify {

struct MeasureJob {
  PingRange sequences;             // [first, last), at least one
  std::optional<PingRange> pings;  // of each sequence; absent: all
  std::uint32_t pings_each = 1;    // of the first sequence
  bool vary = false;               // each has a world of its own

  std::uint32_t count() const { return sequences.second - sequences.first; }
  // May be called from several threads at once.
  std::function<Result<ReadyWorld>(std::uint32_t sequence)> world;
  const Numerics& numerics;
  int threads = 1;
  double seconds = 3;  // pings start within this time, except the first one of each thread
  std::uint32_t most_pings = 4096;  // limit per sequence
  std::uint32_t most_sequences = 1000;
  // Where files without a name measure the time of writing, and vanish; empty: nothing is written.
  std::filesystem::path disk = {};
  std::uint32_t first = 0;  // the sequence whose world exists already
};

// Means over the measured pings. Seconds are those of one thread while all threads work.
struct Measured {
  std::uint64_t pings = 0, sequences = 0;  // how many were measured
  double once_s = 0;        // for a world that all sequences share: tables and calibration
  double world_s = 0;       // for a sequence that has a world of its own
  double prepare_s = 0;     // for any sequence, before its pings
  double first_ping_s = 0;  // for ping 0, a part of which is done by then
  double ping_s = 0;        // for any other ping
  double finish_s = 0;      // for a ping, when its sequence is finished: arrays, tables, manifest
  double list_s = 0;        // ... and when the data set is finished, by one thread
  double cores = 1;         // processor seconds per second of these times
  // Bytes per ping, as in dataset/footprint.h, and per sequence.
  double files = 0, piece = 0, sequence_lines = 0, dataset_lines = 0, record = 0;
  double sequence_bytes = 0;
};

// `first`: known parts of the world of the first sequence, or of the world that all share, to which
// new parts are added. Errors: those of job.world, make_pipeline and encode_ping. Throws
// DeviceFailure.
Result<Measured> measure_pings(const MeasureJob& job, SharedParts& first);

// At most `most` of the pings [first, last): the first, the last, the middle one, then the middles
// of the intervals between them, so that any leading part of the list is evenly spread.
std::vector<std::uint32_t> spread_order(std::uint32_t first, std::uint32_t last,
                                        std::uint32_t most);

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

// From the first ping to the end of the last file, for the sequences of the job.
RunTime time_of(const Measured& measured, const MeasureJob& job);

}  // namespace ensonify
