// The time series of a ping, as its receiver delivers it.
//
//   places_key  keys_of
//   ReceivedSeries  received_series   echoes, noise, electronics, ADC and detector
//   drawn_series                      the same of several draws of one scene
//   moment_sums  add_draws            their moments, where the backend adds them itself
//   received_layers                   the signal components that add up to it
//   polar_levels_db                   its levels as an image
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/ping.h"
#include "ping/ping_echoes.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "synthesis/backend.h"

namespace ensonify {

// Keys the places of scatterers on surfaces and the directions of bounces, with any speckle seed.
std::uint64_t places_key(const SequenceInfo& info);

// The keys of amplitudes and noise.
RandomKeys keys_of(const SequenceInfo& info, std::uint32_t ping);

// With a detector, `level_db` are its levels, and `pressure_pa` is filled as well.
struct ReceivedSeries : PingSeries {
  std::vector<std::uint8_t> artifact;  // bits of Artifact, [samples x beams]; empty: not asked for
};

// What the series of a ping is made from. References must outlive the call.
struct ReceivedParts {
  const Session& session;
  const SequenceInfo& info;
  const PipelineTables& tables;
  const PingEchoes& echoes;
  std::uint32_t ping = 0;
};

// With `only_level`, the backend may return levels in place of pressures.
ReceivedSeries received_series(const ReceivedParts& parts, bool wants_clean, bool only_level,
                               const Workers& workers);

// Writes the pressures of pings parts.ping, parts.ping + 1 ..., which all have these echoes and
// differ in random numbers alone. Each ping is that of received_series. Vectors keep their memory.
void drawn_series(const ReceivedParts& parts, const Workers& workers,
                  std::span<Series> pressure_pa);

// As Backend::moment_sums. Also null if correlated noise or electronics are added to the series of
// the backend, which must then be handed over.
std::unique_ptr<MomentSums> moment_sums(const ReceivedParts& parts, const Moments& moments,
                                        const PooledPixels& pool);

// Adds `count` pings as drawn_series makes them. Returns the number that was added, as
// MomentSums::add.
std::uint32_t add_draws(const ReceivedParts& parts, std::uint32_t count, const Workers& workers,
                        MomentSums& sums);

// As info.layers. `whole` is the result of received_series; `layer_of_instance` that of
// layer_table.
std::vector<LayerSeries> received_layers(const ReceivedParts& parts,
                                         const std::vector<Layer>& layer_of_instance,
                                         const PingSeries& whole, const Workers& workers);

// image_level_db of a series, [samples x beams] from [beams x samples].
std::vector<float> polar_levels_db(std::span<const std::complex<float>> pressure_pa,
                                   std::size_t beams);

}  // namespace ensonify
