#include "core/sonar.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"

namespace ensonify {
namespace {

// Room for the pulse's tails, so that an echo in the last sample does not wrap around into the
// first.
constexpr int kPaddingSamples = 64;

}  // namespace

const char* name_of(PulseShape shape) {
  switch (shape) {
    case PulseShape::gaussian:
      return "gaussian";
    case PulseShape::flat:
      return "flat";
    case PulseShape::lfm:
      return "lfm";
    case PulseShape::cw:
      return "cw";
    case PulseShape::table:
      return "table";
  }
  return "";
}

const char* name_of(Window window) {
  switch (window) {
    case Window::none:
      return "none";
    case Window::hann:
      return "hann";
    case Window::hamming:
      return "hamming";
    case Window::blackman:
      return "blackman";
  }
  return "";
}

const char* name_of(Shading shading) {
  switch (shading) {
    case Shading::uniform:
      return "uniform";
    case Shading::hann:
      return "hann";
    case Shading::taylor:
      return "taylor";
    case Shading::chebyshev:
      return "chebyshev";
  }
  return "";
}

const char* name_of(Focus focus) { return focus == Focus::none ? "none" : "dynamic"; }

const char* name_of(Steering steering) {
  return steering == Steering::phase ? "phase" : "true_delay";
}

const char* name_of(SpeckleMode speckle) {
  switch (speckle) {
    case SpeckleMode::per_ping:
      return "per_ping";
    case SpeckleMode::per_ray:
      return "per_ray";
    case SpeckleMode::surface:
      return "surface";
  }
  return "";
}

double beam_azimuth_rad(const Sonar& sonar, int beam) {
  if (!sonar.azimuth_rad.empty()) return sonar.azimuth_rad[static_cast<std::size_t>(beam)];
  return (beam - (sonar.beam_count - 1) / 2.0) * sonar.beam_spacing_rad;
}

std::vector<double> beam_azimuths_rad(const Sonar& sonar) {
  std::vector<double> azimuths(sonar.beam_count);
  for (int j = 0; j < sonar.beam_count; ++j) azimuths[j] = beam_azimuth_rad(sonar, j);
  return azimuths;
}

std::vector<double> beam_borders_rad(const Sonar& sonar) {
  std::vector<double> borders;
  const auto& azimuths = sonar.azimuth_rad;
  if (azimuths.size() < 2) {
    for (int k = 0; k <= sonar.beam_count; ++k) {
      borders.push_back((k - sonar.beam_count / 2.0) * sonar.beam_spacing_rad);
    }
    return borders;
  }
  borders.push_back(azimuths[0] - (azimuths[1] - azimuths[0]) / 2);
  for (std::size_t k = 1; k < azimuths.size(); ++k) {
    borders.push_back((azimuths[k - 1] + azimuths[k]) / 2);
  }
  borders.push_back(2 * azimuths.back() - borders.back());
  return borders;
}

double beam_place(const Sonar& sonar, double azimuth_rad) {
  const auto& azimuths = sonar.azimuth_rad;
  if (azimuths.size() < 2) {
    return azimuth_rad / sonar.beam_spacing_rad + (sonar.beam_count - 1) / 2.0;
  }
  const auto above = std::upper_bound(azimuths.begin() + 1, azimuths.end() - 1, azimuth_rad);
  const auto beam = static_cast<std::size_t>(above - azimuths.begin()) - 1;
  const double low = azimuths[beam];
  return static_cast<double>(beam) + (azimuth_rad - low) / (azimuths[beam + 1] - low);
}

std::optional<int> sector_of(const Sonar& sonar, double azimuth_rad) {
  const double position = sonar.azimuth_rad.empty()
                              ? azimuth_rad / sonar.beam_spacing_rad + sonar.beam_count / 2.0
                              : beam_place(sonar, azimuth_rad) + 0.5;
  if (!(position >= 0 && position < sonar.beam_count)) return std::nullopt;
  return static_cast<int>(position);
}

double width_of_beam_rad(const Sonar& sonar, int beam) {
  return sonar.width_rad.empty() ? sonar.beam_width_rad
                                 : sonar.width_rad[static_cast<std::size_t>(beam)];
}

double cell_width_rad(const Sonar& sonar, int beam) {
  const auto& azimuths = sonar.azimuth_rad;
  if (azimuths.size() < 2) return sonar.beam_spacing_rad;
  const auto j = static_cast<std::size_t>(beam), last = azimuths.size() - 1;
  if (j == 0) return azimuths[1] - azimuths[0];
  if (j == last) return azimuths[last] - azimuths[last - 1];
  return (azimuths[j + 1] - azimuths[j - 1]) / 2;
}

double cell_middle_rad(const Sonar& sonar, int beam) {
  const double azimuth = beam_azimuth_rad(sonar, beam);
  const auto& azimuths = sonar.azimuth_rad;
  const auto j = static_cast<std::size_t>(beam);
  if (azimuths.size() < 2 || j == 0 || j + 1 == azimuths.size()) return azimuth;
  return (azimuths[j - 1] + 2 * azimuth + azimuths[j + 1]) / 4;
}

double narrowest_cell_rad(const Sonar& sonar) {
  double narrowest = cell_width_rad(sonar, 0);
  for (std::size_t j = 1; j < sonar.azimuth_rad.size(); ++j) {
    narrowest = std::min(narrowest, cell_width_rad(sonar, static_cast<int>(j)));
  }
  return narrowest;
}

double furthest_azimuth_rad(const Sonar& sonar) {
  const auto& azimuths = sonar.azimuth_rad;
  if (azimuths.size() < 2) return sonar.beam_count * sonar.beam_spacing_rad / 2;
  const double low = azimuths.front() - cell_width_rad(sonar, 0) / 2;
  const double high = azimuths.back() + cell_width_rad(sonar, sonar.beam_count - 1) / 2;
  return std::max(std::abs(low), std::abs(high));
}

Record make_record(const Sonar& sonar, const Water& water, double pulse_extent_s) {
  Record record;
  record.samples = static_cast<int>(
      std::ceil(sonar.bandwidth_hz * 2.0 * sonar.range_max_m / water.sound_speed_m_s));
  record.transform =
      smooth_even_length(record.samples + kPaddingSamples +
                         static_cast<int>(std::ceil(sonar.bandwidth_hz * pulse_extent_s)));
  record.sample_interval_s = 1.0 / sonar.bandwidth_hz;
  return record;
}

double sample_range_m(const Sonar& sonar, const Water& water, int sample) {
  return sonar.first_range_m + water.sound_speed_m_s * sample / (2.0 * sonar.bandwidth_hz);
}

double range_step_m(const Sonar& sonar, const Water& water) {
  return water.sound_speed_m_s / (2.0 * sonar.bandwidth_hz);
}

int smooth_even_length(int n) {
  ENSONIFY_ASSERT(n >= 1);
  for (int length = n + (n & 1);; length += 2) {
    int rest = length;
    for (const int prime : {2, 3, 5}) {
      while (rest % prime == 0) rest /= prime;
    }
    if (rest == 1) return length;
  }
}

double source_pressure_pa_m(const Sonar& sonar) {
  return std::pow(10.0, (sonar.source_level_db - 120.0) / 20.0);
}

int group_of(const Sonar& sonar, int beam) {
  if (!sonar.transmit) return 0;
  if (sonar.transmit->sector_beams.empty()) return beam % sonar.transmit->count;
  int group = 0;
  for (int left = beam; left >= sonar.transmit->sector_beams[group]; ++group) {
    left -= sonar.transmit->sector_beams[group];
  }
  return group;
}

GroupBeams beams_of_group(const Sonar& sonar, int group) {
  const int groups = group_count(sonar);
  if (!sonar.transmit || sonar.transmit->sector_beams.empty()) {
    return {group, groups, sonar.beam_count / groups};
  }
  const auto sizes = sonar.transmit->sector_beams.begin();
  return {std::accumulate(sizes, sizes + group, 0), 1, sizes[group]};
}

double carrier_hz(const Sonar& sonar, int group) {
  const bool own = sonar.transmit && !sonar.transmit->frequency_hz.empty();
  return own ? sonar.transmit->frequency_hz[group] : sonar.frequency_hz;
}

double fired_after_s(const Sonar& sonar, int group) {
  if (!sonar.transmit) return 0;
  const std::vector<int>& order = sonar.transmit->order;
  const auto turn = std::find(order.begin(), order.end(), group) - order.begin();
  return static_cast<double>(turn) * sonar.transmit->interval_s;
}

}  // namespace ensonify
