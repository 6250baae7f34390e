// A few pings of a run made in memory as `generate` makes them, and what follows from them for the
// whole run.
//
//   MeasureJob                     what is to be made
//   Measured  measure_pings        what a few of its pings took and became
//   spread_order                   which of them
//   RunTime  time_now  time_of     what the run will take
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "app/pipeline.h"
#include "app/sequence_worlds.h"
#include "app/tables.h"
#include "core/error.h"

namespace ensonify {

struct MeasureJob {
  PingRange sequences;             // [first, last), at least one
  std::optional<PingRange> pings;  // of each; absent: all that it has
  std::uint32_t pings_each = 1;    // as many as the first has of them
  bool vary = false;               // each has a world of its own

  std::uint32_t count() const { return sequences.second - sequences.first; }
  // May be called from several threads at once.
  std::function<Result<ReadyWorld>(std::uint32_t sequence)> world;
  const Numerics& numerics;
  int threads = 1;
  double seconds = 3;  // pings begin within this time, but for the first ones, one a thread
  std::uint32_t most_pings = 4096;  // of a sequence
  std::uint32_t most_sequences = 1000;
  // Where files without a name show what writing takes, and vanish; empty: nothing is written.
  std::filesystem::path disk = {};
  std::uint32_t first = 0;  // the sequence whose world is there already
};

// Means over what was measured. Seconds are those of one thread, while all threads work.
struct Measured {
  std::uint64_t pings = 0, sequences = 0;  // how many were measured
  double once_s = 0;        // of a world that all sequences share: its tables, and calibration
  double world_s = 0;       // of a sequence that has a world of its own
  double prepare_s = 0;     // of any sequence, before its pings
  double first_ping_s = 0;  // of ping 0, a part of which is done by then
  double ping_s = 0;        // of any other ping
  double store_s = 0;       // of any ping, while others are computed
  double join_s = 0;        // of a ping: its part of arrays, put behind the others
  double finish_s = 0;      // of a ping: its lines in the tables and manifests, written once
  double cores = 1;         // processor seconds to a second of the above
  // Bytes of a ping, as in dataset/footprint.h, and of a sequence.
  double files = 0, piece = 0, sequence_lines = 0, dataset_lines = 0, record = 0;
  double sequence_bytes = 0;
};

// `first`: what is known of the world of the first sequence, or of the one that all share; what is worked
// out there is added. Errors: those of job.world, make_pipeline and encode_ping. Throws
// DeviceFailure.
Result<Measured> measure_pings(const MeasureJob& job, SharedParts& first);

// At most `most` of the pings [first, last): the first, the last, the middle one, then those in the
// middle of what is between them, so that any number of them from the front are spread.
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

// Of a clock, and of all threads of this process.
RunTime time_now();

// From the first ping to the end of the last file, of the sequences of the job.
RunTime time_of(const Measured& measured, const MeasureJob& job);

}  // namespace ensonify
