// What a volume of water throws back in one ping: too many scatterers to list, so their expected
// energy, sector by sector and sample by sample.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ensonify {

// Row-major [beams x samples], of the ideal sector's echoes with delays in
// [(n - 1/2)/b, (n + 1/2)/b).
struct VolumeEcho {
  std::uint32_t instance = 0;
  std::vector<float> energy;            // E|a|^2 gain^2 summed, 1/m^2; without S0
  std::vector<float> elevation_rad;     // energy-weighted mean of arrival
  std::vector<float> elevation_square;  // energy-weighted mean of its square, rad^2
};

// The energy of all volumes in one cell; `cell` indexes [beams x samples].
inline double total_energy(std::span<const VolumeEcho> volumes, std::size_t cell) {
  double sum = 0;
  for (const VolumeEcho& volume : volumes) sum += volume.energy[cell];
  return sum;
}

}  // namespace ensonify
