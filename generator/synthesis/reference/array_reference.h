// The oracle of the element-level array (synthesis/beamforming.h).
#pragma once

#include <memory>

#include "synthesis/backend.h"

namespace ensonify {

// Double precision, element by element and scatterer by scatterer, expected power included: for
// small cases. Needs setup.sonar.array.
std::unique_ptr<Backend> make_array_reference_backend(const SynthesisSetup& setup);

}  // namespace ensonify
