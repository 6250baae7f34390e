// The reference for the element-level array (synthesis/beamforming.h).
#pragma once

#include <memory>

#include "synthesis/backend.h"

namespace ensonify {

// Computes series and expected power in double precision, element by element and scatterer by
// scatterer. It is slow, and therefore for small cases only. Needs setup.sonar.array.
std::unique_ptr<Backend> make_array_reference_backend(const SynthesisSetup& setup);

}  // namespace ensonify
