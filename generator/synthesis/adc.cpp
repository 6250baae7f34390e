#include "synthesis/adc.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace ensonify {

void quantise(const Adc& adc, std::span<std::complex<float>> pressure_pa) {
  ENSONIFY_ASSERT(adc.bits >= 1);
  const double steps = std::ldexp(1.0, adc.bits - 1);  // from zero to full scale
  const double step_pa = std::pow(10.0, (adc.full_scale_db - 120.0) / 20.0) / steps;
  const auto convert = [&](float part) {
    // nearbyint rounds ties to even.
    return static_cast<float>(std::clamp(std::nearbyint(part / step_pa), -steps, steps - 1) *
                              step_pa);
  };
  for (std::complex<float>& p : pressure_pa) p = {convert(p.real()), convert(p.imag())};
}

}  // namespace ensonify
