#include "synthesis/adc.h"

#include "core/error.h"

namespace ensonify {

Converter converter_of(const Adc& adc) {
  ENSONIFY_ASSERT(adc.bits >= 1);
  const double steps = std::ldexp(1.0, adc.bits - 1);
  return {std::pow(10.0, (adc.full_scale_db - 120.0) / 20.0) / steps, steps};
}

void quantise(const Adc& adc, std::span<std::complex<float>> pressure_pa) {
  const Converter converter = converter_of(adc);
  for (std::complex<float>& p : pressure_pa) {
    p = {converted(converter, p.real()), converted(converter, p.imag())};
  }
}

}  // namespace ensonify
