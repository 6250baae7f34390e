// The pings of a batch as a device takes them.
//
//   PingBatch      fill_batch
//   fill_arrivals  array_echo_bytes   what it holds for an array beside what it holds for sectors
#pragma once

#include <memory_resource>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "synthesis/backend.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

struct PingBatch {
  // Memory for all of it.
  explicit PingBatch(std::pmr::memory_resource* memory = std::pmr::get_default_resource());

  std::pmr::vector<EchoRecord> echoes;      // of all pings, one after another
  std::pmr::vector<std::uint32_t> ping_of;  // [echoes]
  std::pmr::vector<std::uint32_t> offset;   // [pings][sectors + 1], among all echoes
  std::pmr::vector<DopplerRecord> shifts;   // of those with doppler != 0, in the same order
  std::pmr::vector<std::uint32_t>
      shift_offset;  // as offset, among all shifts; empty: there are none
  std::pmr::vector<BatchPing> pings;
  std::pmr::vector<std::uint64_t> volume_key;  // [pings]
  std::pmr::vector<float> energy;  // [pings][sectors][samples] of all volumes; empty: none has any
  // For an array, whose echoes and shifts are in the order of their delays, ping by ping: of the
  // offsets only where pings begin and end holds.
  std::pmr::vector<ArrivalRecord> arrivals;          // [echoes]
  std::pmr::vector<DirectionRecord> directed;        // [echoes], by first node, then by delay
  std::pmr::vector<std::uint32_t> direction_offset;  // [pings][nodes - kPatternTaps + 2]
  bool wants_channels = false;
  bool has_means = false, has_noise = false, wants_clean = false;
};

// Memory is used again.
void fill_batch(const SynthesisSetup& setup, std::span<const PingTask> tasks,
                const Workers& workers, PingBatch& batch);

// Puts the echoes and shifts of every ping, filled in already, into the order of delays, and fills
// in where echoes come from. Needs setup.sonar.array.
void fill_arrivals(const SynthesisSetup& setup, std::span<const PingTask> tasks,
                   const Workers& workers, PingBatch& batch);

// What each echo takes on the host.
std::uint64_t array_echo_bytes();

}  // namespace ensonify
