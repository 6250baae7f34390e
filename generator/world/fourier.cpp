#include "world/fourier.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/error.h"
#include "core/units.h"

namespace ensonify {

FourierSum::FourierSum(std::size_t length) : turns_(length / 2), reversed_(length) {
  ENSONIFY_ASSERT(std::has_single_bit(length) && length >= 2);
  for (std::size_t j = 0; j < turns_.size(); ++j) {
    const double angle = 2 * kPi * static_cast<double>(j) / static_cast<double>(length);
    turns_[j] = {std::cos(angle), std::sin(angle)};
  }
  for (std::size_t i = 1; i < length; ++i) {
    reversed_[i] = reversed_[i / 2] / 2 + (i % 2 ? static_cast<std::uint32_t>(length / 2) : 0);
  }
}

void FourierSum::run(std::complex<double>* data) const {
  const std::size_t length = reversed_.size();
  for (std::size_t i = 0; i < length; ++i) {
    if (i < reversed_[i]) std::swap(data[i], data[reversed_[i]]);
  }
  for (std::size_t half = 1; half < length; half *= 2) {
    const std::size_t stride = length / (2 * half);
    for (std::size_t start = 0; start < length; start += 2 * half) {
      for (std::size_t j = 0; j < half; ++j) {
        const std::complex<double> turn = turns_[j * stride];
        std::complex<double>&even = data[start + j], &odd = data[start + j + half];
        const std::complex<double> turned{odd.real() * turn.real() - odd.imag() * turn.imag(),
                                          odd.real() * turn.imag() + odd.imag() * turn.real()};
        odd = even - turned;
        even += turned;
      }
    }
  }
}

}  // namespace ensonify
