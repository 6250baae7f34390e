// The pings of a batch in the format for a device.
//
//   PingBatch      fill_batch  fill_keys
//   fill_arrivals  array_echo_bytes   the additional data for an array
#pragma once

#include <memory_resource>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "synthesis/backend.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

struct PingBatch {
  // `memory` provides the memory for all vectors.
  explicit PingBatch(std::pmr::memory_resource* memory = std::pmr::get_default_resource());

  std::pmr::vector<EchoRecord> echoes;      // of all pings, one ping after another
  std::pmr::vector<std::uint32_t> ping_of;  // [echoes]
  std::pmr::vector<std::uint32_t> offset;   // [pings][sectors + 1], index into `echoes`
  std::pmr::vector<DopplerRecord> shifts;   // of those with doppler != 0, in the same order
  std::pmr::vector<std::uint32_t>
      shift_offset;  // [pings][sectors + 1], index into `shifts`; empty if there are none
  std::pmr::vector<BatchPing> pings;
  std::pmr::vector<std::uint64_t> volume_key;  // [pings]
  std::pmr::vector<float> energy;  // [pings][sectors][samples], sum of volumes; empty without
  // For an array. Its echoes and shifts are sorted by delay within each ping, so that of the
  // offsets only the begin and the end of each ping are valid.
  std::pmr::vector<ArrivalRecord> arrivals;          // [echoes]
  std::pmr::vector<DirectionRecord> directed;        // [echoes], by first node, then by delay
  std::pmr::vector<std::uint32_t> direction_offset;  // [pings][nodes - kPatternTaps + 2]
  bool wants_channels = false;
  bool has_means = false, has_noise = false, wants_clean = false;
};

// Fills a batch with tasks, and reuses its memory.
void fill_batch(const SynthesisSetup& setup, std::span<const PingTask> tasks,
                const Workers& workers, PingBatch& batch);

// Replaces only the keys and the noise of the pings of a batch that has been filled with as many
// tasks.
void fill_keys(const SynthesisSetup& setup, std::span<const PingTask> tasks, PingBatch& batch);

// Sorts the echoes and shifts of every ping by delay, and writes arrivals and directions. Call it
// after fill_batch has written the echoes. Needs setup.sonar.array.
void fill_arrivals(const SynthesisSetup& setup, std::span<const PingTask> tasks,
                   const Workers& workers, PingBatch& batch);

// Host memory for each echo.
std::uint64_t array_echo_bytes();

}  // namespace ensonify
