// The record between tracing and synthesis: the echoes of one ping, and those that surfaces hide.
//
// The record is made once per ping, and all backends and the labels read it. It has no ray grid: an
// echo from a refracted ray, a bounce or a fixed surface scatterer is one more entry.
//
//   Scatterer  ScattererList
//   sorted_by_beam_and_delay  append  with_more  sort_keys
//   VolumeEcho  total_energy   echoes of a volume of water, which has too many scatterers to list
//   HiddenEchoes               hidden echoes, for shadows and amodal masks
//   ElevationEcho  elevation_step_of   echoes over elevation, before pulse and beams spread them
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/surface.h"
#include "core/vec.h"

namespace ensonify {

// Direction in the sonar frame: azimuth = atan2(y, x), elevation = asin(z / r).
struct Direction {
  float azimuth_rad = 0;
  float elevation_rad = 0;
};

// The unit vector of a direction given in double precision.
inline Vec3 unit_vector(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::cos(azimuth_rad),
          std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad)};
}

// One scatterer. Its echo in its own beam cell is S0 a gain e^(-i 2 pi f_c delay) s(t - delay),
// with a = mean + standard_deviation * xi(key), xi circular complex normal, E|xi|^2 = 1.
struct Scatterer {
  double delay_s = 0;   // two-way
  Vec3 position_m;      // sonar frame, at transmission
  Direction departure;  // of the transmitted path
  Direction arrival;    // of the received path; its azimuth chooses the sector
  float gain = 0;       // spreading, absorption and elevation pattern, both ways
  std::complex<float> mean;
  float standard_deviation = 0;
  float cos_incidence = 0;
  float doppler = 0;  // relative frequency shift; 0 at rest
  // Identity for random draws, independent of threads and order. Only the two directions around a
  // bounced path and the taps of walls and spheres share it, and thus the draw.
  std::uint64_t key = 0;
  std::uint32_t beam = 0;  // the sector of arrival
  std::uint32_t instance = 0;
  std::uint16_t path = 0;  // 0 direct; others as SequenceInfo::paths
  // With `bounces` or walls: the instances of the path's other surfaces, in the order of the sound,
  // then of the walls that it passes; 0: no more.
  std::array<std::uint16_t, kMostBounces> via{};
  // Length of the received path: the sound arrives as if from received_path_m along `arrival`.
  float received_path_m = 0;
  // How much of delay_s is not travel: walls and targets that ring echo later than the sound takes,
  // and the surface of a target earlier than its center.
  float lag_s = 0;
};

// All scatterers of one ping, sorted by beam, then delay, then key. Two scatterers with the same
// key keep their order. Those of beam j are [beam_offset[j], beam_offset[j + 1]).
struct ScattererList {
  std::vector<std::uint32_t> beam_offset;  // [beams + 1]
  std::vector<Scatterer> items;

  std::size_t size() const { return items.size(); }
};

// Sorts scatterers into a list. Keeps all; every beam must be below `beams`.
ScattererList sorted_by_beam_and_delay(std::vector<Scatterer> scatterers, int beams);
ScattererList sorted_by_beam_and_delay(std::span<const Scatterer> scatterers, int beams,
                                       const Workers& workers);

// Appends all parts to `all` and frees the memory of each.
void append(std::span<std::vector<Scatterer>> parts, std::vector<Scatterer>& all);

// Merges more scatterers into a sorted list.
ScattererList with_more(ScattererList list, std::span<const Scatterer> more,
                        const Workers& workers);

// Sort keys of one beam cell's scatterers and their indices, which are cheaper to move.
struct SortKey {
  double delay_s = 0;
  std::uint64_t key = 0;
  std::uint32_t index = 0;
};
// By delay, then key, then index.
void sort_keys(std::vector<SortKey>& keys);

// Row-major [beams x samples], of the ideal beam cell's echoes with delays in
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

struct HiddenEchoes {
  ScattererList list;                   // echoes as if nothing were in front of them
  std::vector<std::uint32_t> occluder;  // for each: the only instance that hides it; 0: several do
  // By instance id: share of the rays (point targets, fish) to it that meet another instance first.
  // NaN: none reaches it.
  std::vector<double> occlusion;
};

// Echoes of one surface or volume in a step of elevation and a 128th of a sample, at the peak of
// the pulse that the ideal beam cell receives.
struct ElevationEcho {
  std::int32_t sample = 0;  // the nearest one to the delay; may lie outside of the record
  std::uint16_t beam = 0;   // the beam cell of arrival
  std::int16_t step = 0;    // elevation_step_of the arrival
  float offset = 0;         // from the sample to the delay, in samples
  float diffuse_pa2 = 0;    // sum of S0^2 gain^2 variance
  std::complex<float> coherent_pa = 0;  // sum of S0 gain mean e^(-i 2 pi f_c delay)
  std::uint16_t instance = 0;
  std::uint16_t path = 0;  // 0 direct; others as SequenceInfo::paths
};

// The step k of an elevation, from k to k + 1 times the step; step 0 begins at the plane of the
// sonar. Elevations are those of Direction, in single precision.
inline std::int16_t elevation_step_of(float elevation_rad, double step_rad) {
  return static_cast<std::int16_t>(std::floor(double{elevation_rad} / step_rad));
}

}  // namespace ensonify
