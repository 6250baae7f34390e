// What a batch holds for an array beside what it holds for beams of sectors.
#pragma once

#include <span>

#include "core/parallel.h"
#include "synthesis/backend.h"
#include "synthesis/cuda/ping_batch.h"

namespace ensonify {

// Puts the echoes and shifts of every ping, filled in already, into the order of delays, and fills
// in where echoes come from. Needs setup.sonar.array.
void fill_arrivals(const SynthesisSetup& setup, std::span<const PingTask> tasks,
                   const Workers& workers, PingBatch& batch);

// Of each echo, on the host.
std::uint64_t array_echo_bytes();

}  // namespace ensonify
