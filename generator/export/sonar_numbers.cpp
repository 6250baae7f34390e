#include "export/sonar_numbers.h"

#include <algorithm>
#include <cmath>

#include "acoustics/pattern.h"
#include "acoustics/pulse.h"
#include "core/units.h"

namespace ensonify {
namespace {

// Steps of an integral in a -3 dB width.
constexpr double kStepsPerWidth = 32;

// The integral of `power` from -90 to 90 degrees, by the midpoint rule.
template <class Power>
double integral_ahead(double width_rad, Power power) {
  const int steps = static_cast<int>(std::ceil(kStepsPerWidth * kPi / width_rad));
  const double step = kPi / steps;
  double sum = 0;
  for (int i = 0; i < steps; ++i) sum += power(-kPi / 2 + (i + 0.5) * step);
  return sum * step;
}

// Manifests do not hold all numbers of a shaded line.
ShadedLine elevation_line(const Sonar& sonar) {
  return make_shaded_line(sonar.elevation_line.shading, sonar.elevation_width_rad);
}

// -3 dB width of the shaded line that is as long as the array, steered ahead.
double array_line_width_rad(const SequenceInfo& info) {
  const auto& array = *info.sonar.array;
  constexpr double kSmall_rad = 1e-3;
  const double wavelength_m = info.water.sound_speed_m_s / info.sonar.frequency_hz;
  const double aperture = array.elements * array.spacing_m / wavelength_m;
  return kSmall_rad * make_shaded_line(array.shading, kSmall_rad).aperture / aperture;
}

}  // namespace

double one_way_elevation_width_rad(const Sonar& sonar) {
  const ShadedLine line = elevation_line(sonar);
  // The one-way power is half where the two-way amplitude is. Side lobes are lower.
  double inside = 0, outside = kPi / 2;
  if (shaded_pattern(line, outside) > 0.5) return kPi;
  for (int i = 0; i < 60; ++i) {
    const double middle = (inside + outside) / 2;
    (shaded_pattern(line, middle) > 0.5 ? inside : outside) = middle;
  }
  return 2 * inside;
}

double receive_width_rad(const SequenceInfo& info, int beam) {
  const Sonar& sonar = info.sonar;
  return sonar.array ? array_line_width_rad(info) / std::cos(beam_azimuth_rad(sonar, beam))
                     : width_of_beam_rad(sonar, beam);
}

double transmit_on_axis(const Sonar& sonar, int beam) {
  constexpr double kLeast = 1e-3;
  const double pattern = transmit_pattern(beam_azimuth_rad(sonar, beam), sonar.transmit_width_rad);
  return std::max(std::abs(pattern), kLeast);
}

double equivalent_beam_angle_sr(const SequenceInfo& info, int beam) {
  const Sonar& sonar = info.sonar;
  const double at = beam_azimuth_rad(sonar, beam);
  // Delays steer an array in the sine of the angle.
  const double width = sonar.array ? array_line_width_rad(info) : width_of_beam_rad(sonar, beam);
  const ShadedLine across =
      make_shaded_line(sonar.array ? sonar.array->shading : sonar.shading, width);
  const double azimuth = integral_ahead(width, [&](double angle) {
    const double receive =
        sonar.array ? shaded_line(across, across.aperture * (std::sin(angle) - std::sin(at)))
                    : shaded_pattern(across, angle - at);
    const double transmit = transmit_pattern(angle, sonar.transmit_width_rad);
    return receive * receive * transmit * transmit;
  });
  const ShadedLine upright = elevation_line(sonar);
  const double elevation = integral_ahead(sonar.elevation_width_rad, [&](double angle) {
    const double both = shaded_pattern(upright, angle);
    return both * both * std::cos(angle);
  });
  const double on_axis = transmit_on_axis(sonar, beam);
  return azimuth * elevation / (on_axis * on_axis);
}

double effective_pulse_s(const SequenceInfo& info) {
  constexpr int kOversampling = 8;
  const std::vector<double> power =
      envelope_squared(pulse_spectrum(info.sonar, info.record.transform), kOversampling);
  double sum = 0, peak = 0;
  for (const double value : power) {
    sum += value;
    peak = std::max(peak, value);
  }
  return sum / (peak * kOversampling * info.sonar.bandwidth_hz);
}

}  // namespace ensonify
