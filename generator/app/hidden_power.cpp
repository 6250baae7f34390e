#include "app/hidden_power.h"

#include <cstdlib>

#include "acoustics/envelope.h"
#include "acoustics/pulse.h"
#include "labels/shadow.h"
#include "synthesis/mixing.h"

namespace ensonify {

HiddenPower hidden_power(const Sonar& sonar, const Record& record) {
  HiddenPower power;
  const Mixing mixing = make_mixing(sonar);
  const double source_pa_m = source_pressure_pa_m(sonar);
  for (int j = 0; j < sonar.beam_count; ++j) {
    double sum = 0;
    for (int i = 0; i < sonar.beam_count; ++i) {
      sum += mixing.weight[std::abs(i - j)] * mixing.weight[std::abs(i - j)];
    }
    const double amplitude = source_pa_m * mixing.scale[j];
    power.per_energy.push_back(amplitude * amplitude * sum);
  }
  constexpr int kHalf = kPulseSteps / 2;  // steps of a sample
  const std::vector<double> square =
      envelope_squared(pulse_spectrum(sonar, record.transform), kHalf);
  const int count = static_cast<int>(square.size());
  for (int k = -kHalf; k <= kHalf; ++k) power.pulse.push_back(square[(k + count) % count]);
  return power;
}

}  // namespace ensonify
