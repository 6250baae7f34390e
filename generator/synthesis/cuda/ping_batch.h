// The pings of a batch as a device takes them.
#pragma once

#include <span>
#include <vector>

#include "core/parallel.h"
#include "synthesis/backend.h"
#include "synthesis/cuda/records.h"

namespace ensonify {

struct PingBatch {
  std::vector<EchoRecord> echoes;           // of all pings, one after another
  std::vector<std::uint32_t> ping_of;       // [echoes]
  std::vector<std::uint32_t> offset;        // [pings][sectors + 1], among all echoes
  std::vector<ShiftRecord> shifts;          // of those with doppler != 0, in the same order
  std::vector<std::uint32_t> shift_offset;  // as offset, among all shifts; empty: there are none
  std::vector<PingRecord> pings;
  std::vector<std::uint64_t> volume_key;  // [pings]
  std::vector<float> energy;  // [pings][sectors][samples] of all volumes; empty: none has any
  // Of an array, whose echoes and shifts are in the order of their delays, ping by ping: of the
  // offsets only where pings begin and end holds.
  std::vector<ArrivalRecord> arrivals;          // [echoes]
  std::vector<DirectionRecord> directed;        // [echoes], by first node, then by delay
  std::vector<std::uint32_t> direction_offset;  // [pings][nodes - kPatternTaps + 2]
  bool wants_channels = false;
  bool has_means = false, has_noise = false, wants_clean = false;
};

// Memory is used again.
void fill_batch(const SynthesisSetup& setup, std::span<const PingTask> tasks,
                const Workers& workers, PingBatch& batch);

}  // namespace ensonify
