// Floats as the pixels of EXR pictures hold them.
#pragma once

#include <cstdint>
#include <span>

namespace ensonify {

// The bits of the nearest halves, half to even. Values beyond the range stop at its ends (+-65504);
// every NaN becomes the same one, 0x7fff. Needs spans of one size.
void to_halves(std::span<const float> values, std::span<std::uint16_t> halves);

// Exact. Needs spans of one size.
void from_halves(std::span<const std::uint16_t> halves, std::span<float> values);

// Each value as a file gives it back.
void round_to_halves(std::span<float> values);

}  // namespace ensonify
