// What all pings of a setup share on a device, worked out on the host.
#pragma once

#include <complex>
#include <vector>

#include "synthesis/backend.h"
#include "synthesis/cpu/spread_kernel.h"
#include "synthesis/cuda/records.h"

namespace ensonify {

inline Complex32 narrow(std::complex<double> z) {
  return {static_cast<float>(z.real()), static_cast<float>(z.imag())};
}

// A spreading kernel with what undoes it: the grid's spectrum times `filter` is the record's.
struct DeviceSpread {
  int points = 0, width = 0, degree = 0;
  std::vector<float> coefficient;  // as DeviceKernel
  // [transform], bin 0 first. upper_filter: of powers, what falls on a bin from a period above it.
  std::vector<Complex32> filter, upper_filter, cell_filter;
};

struct BeamTables {
  DeviceSpread series, power;
  // [kBeamsAThread + 2 beams - 1 + kBeamsAThread]: of sector s in beam j at
  // kBeamsAThread + s - j + beams - 1, zero at both ends.
  std::vector<float> weight, power_weight;
  std::vector<float> scale, power_scale;  // [beams]
};

// A kernel as a device takes it, filters still empty; and one for records of so a spectrum, whose
// echoes err by at most `error`: single precision leaves 1e-6.
DeviceSpread spread_of(const SpreadKernel& kernel, int transform);
DeviceSpread series_spread(const std::vector<std::complex<double>>& spectrum, double error = 3e-6);

// Records agree with the CPU's to 1e-5 of their norm, expected powers to 0.1 dB where they lie
// within 40 dB of the largest.
BeamTables make_beam_tables(const SynthesisSetup& setup);

}  // namespace ensonify
