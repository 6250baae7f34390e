#include "app/hidden_power.h"

#include <cmath>
#include <complex>
#include <cstdlib>

#include "acoustics/envelope.h"
#include "acoustics/pulse.h"
#include "core/units.h"
#include "labels/shadow.h"
#include "synthesis/array.h"
#include "synthesis/mixing.h"

namespace ensonify {

namespace {

double beam_model_power(const Mixing& mixing, double source_pa_m, int beam) {
  double sum = 0;
  for (int i = 0; i < static_cast<int>(mixing.weight.size()); ++i) {
    sum += mixing.weight[std::abs(i - beam)] * mixing.weight[std::abs(i - beam)];
  }
  const double amplitude = source_pa_m * mixing.scale[beam];
  return amplitude * amplitude * sum;
}

// Focused, at the carrier: the elements' sum is a polynomial in the turn from one to the next.
double array_power(const Sonar& sonar, const ArrayGeometry& array, double wavelength_m, int beam) {
  const double steered = std::sin(beam_azimuth_rad(sonar, beam));
  double power = 0;
  for (int i = 0; i < sonar.beam_count; ++i) {
    const double u = std::sin(beam_azimuth_rad(sonar, i));
    const std::complex<double> turn =
        std::polar(1.0, 2 * kPi * sonar.array->spacing_m * (u - steered) / wavelength_m);
    std::complex<double> sum = 0;
    for (std::size_t n = array.weight.size(); n-- > 0;) {
      sum = sum * turn + array.weight[n] * array.response[n];
    }
    const double heard = element_pattern(u, sonar.array->element_width_m, wavelength_m);
    power += heard * heard * std::norm(sum);
  }
  return power;
}

}  // namespace

HiddenPower hidden_power(const Sonar& sonar, const Water& water, const Record& record) {
  HiddenPower power;
  const Mixing mixing = make_mixing(sonar);
  const double source_pa_m = source_pressure_pa_m(sonar);
  const ArrayGeometry array = sonar.array ? make_array_geometry(sonar) : ArrayGeometry{};
  const double wavelength_m = water.sound_speed_m_s / sonar.frequency_hz;
  for (int j = 0; j < sonar.beam_count; ++j) {
    power.per_energy.push_back(sonar.array ? source_pa_m * source_pa_m *
                                                 array_power(sonar, array, wavelength_m, j)
                                           : beam_model_power(mixing, source_pa_m, j));
  }
  constexpr int kHalf = kPulseSteps / 2;  // steps of a sample
  const std::vector<double> square =
      envelope_squared(pulse_spectrum(sonar, record.transform), kHalf);
  const int count = static_cast<int>(square.size());
  for (int k = -kHalf; k <= kHalf; ++k) power.pulse.push_back(square[(k + count) % count]);
  return power;
}

}  // namespace ensonify
