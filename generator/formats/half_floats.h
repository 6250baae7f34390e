// Floats as the pixels of EXR images hold them.
#pragma once

#include <cstdint>
#include <span>

namespace ensonify {

// The bits of the nearest halves, half to even. Values beyond the range become +-65504; every NaN
// becomes 0x7fff. Needs spans of one size.
void to_halves(std::span<const float> values, std::span<std::uint16_t> halves);

// Exact. Needs spans of one size.
void from_halves(std::span<const std::uint16_t> halves, std::span<float> values);

// Rounds each value as storing it in a file does.
void round_to_halves(std::span<float> values);

}  // namespace ensonify
