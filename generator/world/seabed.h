// Seabed made up from a spectrum and from ripples.
//
//   terrain_key         of an object's draws
//   roughness_spectrum  heights' power over wave vectors
//   make_seabed         heights over a grid
#pragma once

#include <cstdint>
#include <string_view>

#include "scenario/terrain_spec.h"
#include "world/height_grid.h"

namespace ensonify {

std::uint64_t terrain_key(std::uint64_t seed, std::uint32_t sequence, std::string_view object);

// W2(K) in m^4, over all wave vectors (two-sided): its integral over the plane is rms^2.
//   W2 = rms^2 (g - 2) / (2 pi) K0^(g - 2) (K^2 + K0^2)^(-g/2),  K0 = 2 pi / outer scale
double roughness_spectrum(const RoughnessSpec& roughness, double wave_number_rad_m);

// Roughness: normal heights, periodic over roughness_period(spec), whose wave vectors lie on that
// period's lattice between 0 (left out: the mean height is 0) and half the grid's sampling rate.
// Each wave's draw is keyed by its place on the lattice: halving the cell keeps all waves there are
// and adds shorter ones. Ripples: trochoids of period mean 0, each with a phase drawn.
// Needs a spec without a file.
HeightGrid make_seabed(const HeightfieldSpec& spec, std::uint64_t key);

}  // namespace ensonify
