// The CPU backend's ways of making a ping of an array.
#pragma once

#include <memory>

#include "synthesis/cpu/ping_synthesis.h"

namespace ensonify {

// Single precision but for the transforms. None where that cannot hold the tolerance.
std::unique_ptr<PingSynthesis> make_array_synthesis(const SynthesisTables& tables);

// Double precision and the definition's own sum over elements, after a deposit for each: within
// 1e-7 of the reference, but a minute where the other takes a second.
std::unique_ptr<PingSynthesis> make_double_array_synthesis(const SynthesisTables& tables);

}  // namespace ensonify
