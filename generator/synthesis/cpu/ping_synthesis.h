// The CPU backend's two ways of making one ping.
#pragma once

#include <complex>
#include <memory>
#include <vector>

#include "synthesis/backend.h"
#include "synthesis/mixing.h"

namespace ensonify {

// What both ways start from.
struct SynthesisTables {
  SynthesisSetup setup;
  Mixing mixing;
  std::vector<std::complex<double>> spectrum;      // pulse_spectrum
  std::vector<std::complex<double>> autospectrum;  // pulse_autospectrum
};

class PingSynthesis {
 public:
  virtual ~PingSynthesis() = default;
  virtual SynthesisMemory memory(bool has_volumes) const = 0;
  virtual void run(const PingTask& task, PingSeries& series, const Workers& workers) const = 0;
};

// Double precision throughout, every beam transformed: within 1e-7 of the reference.
std::unique_ptr<PingSynthesis> make_double_synthesis(const SynthesisTables& tables);

// As few sums as the tolerance allows, single precision but for the transforms. None where that
// cannot hold the tolerance.
std::unique_ptr<PingSynthesis> make_fast_synthesis(const SynthesisTables& tables);

}  // namespace ensonify
