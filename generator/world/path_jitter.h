// Attitude and heave that the sea adds to a way: a sum of sinusoids, known at every instant.
#pragma once

#include <array>
#include <cstdint>

#include "core/vec.h"
#include "scenario/path_spec.h"

namespace ensonify {

struct Sinusoid {
  double rad_s = 0;
  double phase_rad = 0;
};

// Of equal amplitudes sqrt(2 / kTerms) rms, so that the mean square over time tends to rms^2.
struct Jitter {
  static constexpr int kTerms = 32;
  struct Axis {
    double rms = 0;  // radians or metres
    std::array<Sinusoid, kTerms> terms;
  };
  double start_time_s = 0;  // where the phases count from
  Axis roll, pitch, yaw, heave;
};

// Frequencies drawn from a normal density about 1 / period, of standard deviation
// bandwidth / period, cut at three of them: one in each of kTerms strata of equal probability, so
// that each key has the whole spectrum and no two terms fall together.
Jitter make_jitter(const JitterSpec& spec, std::uint64_t key, double start_time_s);

// Roll, pitch and yaw as a further rotation in the body's frame, heave along the world's z.
Pose jittered(const Jitter& jitter, double time_s, const Pose& pose);

}  // namespace ensonify
