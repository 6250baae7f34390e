// The echoes of one beam cell, as labels count them.
//
//   expected_energy
//   SectorEcho  gather_sector   the echoes of a list that have any energy, by delay
//   EchoWindow                  those within one sample of a sample, for rising samples
//   for_each_cell_beside        the cells of a volume that a pixel hears
//   EnergyShare  add_share  strongest   the energy of each instance
#pragma once

#include <algorithm>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/scatterers.h"

namespace ensonify {

// E|a|^2 gain^2, 1/m^2.
inline double expected_energy(const Scatterer& s) {
  const double square = std::norm(std::complex<double>(s.mean)) +
                        static_cast<double>(s.standard_deviation) * s.standard_deviation;
  return square * s.gain * s.gain;
}

// One source of a pixel's energy: a scatterer, or a volume in one of its cells.
struct SectorEcho {
  double sample = 0;  // its delay in samples
  double energy = 0, elevation_rad = 0, elevation_variance_rad2 = 0;
  std::uint32_t instance = 0;
  std::uint32_t occluder = 0;  // the only instance that hides it; 0: none or several do
  bool bounced = false;
  std::uint32_t item = 0;  // of a scatterer: its index in the list
};

// `occluder`: one for each item of the list; empty for echoes that are heard.
inline void gather_sector(const ScattererList& list, std::span<const std::uint32_t> occluder,
                          std::size_t beam, double bandwidth_hz, std::vector<SectorEcho>& echoes) {
  echoes.clear();
  echoes.reserve(list.beam_offset[beam + 1] - list.beam_offset[beam]);
  for (std::size_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
    const Scatterer& s = list.items[i];
    const double energy = expected_energy(s);
    if (!(energy > 0)) continue;
    echoes.push_back({s.delay_s * bandwidth_hz, energy, s.arrival.elevation_rad, 0, s.instance,
                      occluder.empty() ? 0 : occluder[i], s.path != 0,
                      static_cast<std::uint32_t>(i)});
  }
}

class EchoWindow {
 public:
  explicit EchoWindow(std::span<const SectorEcho> echoes, int first_sample = 0)
      : echoes_(echoes),
        low_(std::ranges::lower_bound(echoes, first_sample - 1.0, {}, &SectorEcho::sample) -
             echoes.begin()),
        high_(low_) {}

  std::span<const SectorEcho> at(int sample) {
    while (high_ < echoes_.size() && echoes_[high_].sample <= sample + 1.0) ++high_;
    while (low_ < high_ && echoes_[low_].sample < sample - 1.0) ++low_;
    return echoes_.subspan(low_, high_ - low_);
  }
  // Call it if at() found no echo. Returns the last sample up to which no echo can be heard, at
  // most `end`.
  int silent_until(int end) const {
    if (high_ == echoes_.size() || echoes_[high_].sample > end) return end;
    return static_cast<int>(echoes_[high_].sample) - 2;
  }

 private:
  std::span<const SectorEcho> echoes_;
  std::size_t low_, high_;
};

// Calls visit(cell, weight) for a pixel's own cell of [beams x samples] with weight 1 and the two
// adjacent ones with weight 1/2, since a cell extends c/4b and the pixel c/2b to either side.
template <class Visit>
void for_each_cell_beside(int beam, int sample, int samples, Visit&& visit) {
  for (int n = std::max(0, sample - 1); n <= std::min(samples - 1, sample + 1); ++n) {
    visit(std::size_t(beam) * samples + n, n == sample ? 1.0 : 0.5);
  }
}

struct EnergyShare {
  std::uint32_t instance = 0;
  double energy = 0;
  double power = 0;  // weighted by the pulse
};

inline void add_share(std::uint32_t instance, double energy, double power,
                      std::vector<EnergyShare>& shares) {
  // Searches from the end, because the instance is most often that of the last echo.
  for (std::size_t i = shares.size(); i-- > 0;) {
    if (shares[i].instance != instance) continue;
    shares[i].energy += energy;
    shares[i].power += power;
    return;
  }
  shares.push_back({instance, energy, power});
}

// Needs at least one share; of equal ones the lower id wins.
inline const EnergyShare& strongest(const std::vector<EnergyShare>& shares) {
  return *std::ranges::min_element(shares, [](const EnergyShare& a, const EnergyShare& b) {
    return a.energy != b.energy ? a.energy > b.energy : a.instance < b.instance;
  });
}

}  // namespace ensonify
