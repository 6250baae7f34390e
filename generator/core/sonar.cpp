#include "core/sonar.h"

#include <cmath>

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
  return (beam - (sonar.beam_count - 1) / 2.0) * sonar.beam_spacing_rad;
}

std::vector<double> beam_azimuths_rad(const Sonar& sonar) {
  std::vector<double> azimuths(sonar.beam_count);
  for (int j = 0; j < sonar.beam_count; ++j) azimuths[j] = beam_azimuth_rad(sonar, j);
  return azimuths;
}

std::optional<int> sector_of(const Sonar& sonar, double azimuth_rad) {
  const double position = azimuth_rad / sonar.beam_spacing_rad + sonar.beam_count / 2.0;
  if (!(position >= 0 && position < sonar.beam_count)) return std::nullopt;
  return static_cast<int>(position);
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
  return water.sound_speed_m_s * sample / (2.0 * sonar.bandwidth_hz);
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

}  // namespace ensonify
