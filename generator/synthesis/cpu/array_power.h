// The expected power of an array's beams.
//
// |h_j(t)|^2 of a scatterer is taken as the beam's power pattern at the scatterer's direction and
// the range of the sample, times the power of the beam's envelope: exact for what lies on a beam's
// axis at its focus; the spread of an echo in time by the ways across the array is left out.
// Relative L2 against the definition: 1 % steered by delay and focused, up to 11 % by phase without
// focus.
#pragma once

#include <memory>
#include <vector>

#include "synthesis/cpu/ping_synthesis.h"

namespace ensonify {

class ArrayPower {
 public:
  virtual ~ArrayPower() = default;
  virtual SynthesisMemory memory() const = 0;
  // power: [beams][samples], S0^2 sum variance gain^2 |h|^2, volumes included.
  virtual void diffuse(const PingTask& task, std::vector<float>& power,
                       const Workers& workers) const = 0;
};

std::unique_ptr<const ArrayPower> make_array_power(const SynthesisTables& tables);

bool has_means(const PingTask& task);

}  // namespace ensonify
