// What the electronics before the ADC do to the beams of a ping.
//
//   PingMoment
//   front_end         in the order beam errors, cross-talk, leakage and interference, blanking,
//                     saturation
//   beam_responses    gain and phase errors of the beams of an instrument
//   group_levels_db   errors of the levels that groups of beams transmit
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/sonar.h"

namespace ensonify {

struct PingMoment {
  std::uint64_t seed = 0;
  std::uint32_t sequence = 0, ping = 0;
  double time_s = 0;  // of transmission
};

// exp(g) e^(i phi) for each beam, where 20 log10 exp(g) and phi are normal with these standard
// deviations. They depend only on the seed, because the instrument is the same in all sequences.
std::vector<std::complex<double>> beam_responses(std::uint64_t seed, int beams,
                                                 double gain_error_db, double phase_error_rad);

// [groups]: what each group of sonar.transmit sends in a ping relative to the source level: its
// level_db, and a normal part with standard deviation level_error_db. Empty if all send the same.
std::vector<double> group_levels_db(const Sonar& sonar, const PingMoment& moment);

// Changes `pressure_pa` [beams x samples] in place. Needs sonar.front_end. With `marks`, returns
// bits of Artifact, [samples x beams]; empty otherwise.
std::vector<std::uint8_t> front_end(const Sonar& sonar, const Water& water, const Record& record,
                                    const PingMoment& moment, bool marks,
                                    std::span<std::complex<float>> pressure_pa,
                                    const Workers& workers);

}  // namespace ensonify
