#include "acoustics/envelope.h"

#include <cmath>
#include <cstddef>

#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// std::complex's own product looks for NaNs, which takes longer than the product.
Complex times(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

std::size_t radix_of(std::size_t count) {
  if (count % 4 == 0) return 4;
  for (std::size_t factor = 2; factor * factor <= count; ++factor) {
    if (count % factor == 0) return factor;
  }
  return count;
}

// An inverse Fourier transform of any length, by its prime factors.
class Transform {
 public:
  explicit Transform(std::size_t count) : turn_(count) {
    for (std::size_t k = 0; k < count; ++k) {
      turn_[k] = std::polar(1.0, 2 * kPi * static_cast<double>(k) / static_cast<double>(count));
    }
  }

  // out_j = sum_m in_m e^(i 2 pi j m / count).
  void run(const Complex* in, Complex* out) { part(in, out, turn_.size(), 1); }

 private:
  void part(const Complex* in, Complex* out, std::size_t count, std::size_t stride);
  void join_four(Complex* out, std::size_t part_count, std::size_t stride) const;
  void join(Complex* out, std::size_t radix, std::size_t part_count, std::size_t stride);

  std::vector<Complex> turn_;      // e^(i 2 pi k / count)
  std::vector<Complex> gathered_;  // scratch of join
};

// Of every stride-th number of `in`: transforms of radix interleaved parts, joined.
void Transform::part(const Complex* in, Complex* out, std::size_t count, std::size_t stride) {
  if (count == 1) {
    *out = *in;
    return;
  }
  const std::size_t radix = radix_of(count);
  const std::size_t part_count = count / radix;
  for (std::size_t q = 0; q < radix; ++q) {
    part(in + q * stride, out + q * part_count, part_count, stride * radix);
  }
  if (radix == 4) {
    join_four(out, part_count, stride);
  } else {
    join(out, radix, part_count, stride);
  }
}

void Transform::join_four(Complex* out, std::size_t part_count, std::size_t stride) const {
  for (std::size_t k = 0; k < part_count; ++k) {
    Complex* x = out + k;
    const Complex x1 = times(x[part_count], turn_[k * stride]);
    const Complex x2 = times(x[2 * part_count], turn_[2 * k * stride]);
    const Complex x3 = times(x[3 * part_count], turn_[3 * k * stride]);
    const Complex even = x[0] + x2, even_difference = x[0] - x2;
    const Complex odd = x1 + x3, odd_difference = x1 - x3;
    const Complex quarter{-odd_difference.imag(), odd_difference.real()};
    x[0] = even + odd;
    x[part_count] = even_difference + quarter;
    x[2 * part_count] = even - odd;
    x[3 * part_count] = even_difference - quarter;
  }
}

void Transform::join(Complex* out, std::size_t radix, std::size_t part_count, std::size_t stride) {
  gathered_.resize(radix);
  const std::size_t step = part_count * stride;  // a radix-th of a turn
  for (std::size_t k = 0; k < part_count; ++k) {
    for (std::size_t q = 0; q < radix; ++q) {
      gathered_[q] = times(out[k + q * part_count], turn_[q * k * stride]);
    }
    for (std::size_t r = 0; r < radix; ++r) {
      Complex sum = gathered_[0];
      std::size_t turned = 0;
      for (std::size_t q = 1; q < radix; ++q) {
        turned += r;
        if (turned >= radix) turned -= radix;
        sum += times(gathered_[q], turn_[turned * step]);
      }
      out[k + r * part_count] = sum;
    }
  }
}

}  // namespace

std::vector<double> envelope_squared(const std::vector<Complex>& spectrum, int oversampling) {
  ENSONIFY_ASSERT(!spectrum.empty() && oversampling >= 1);
  const std::size_t count = spectrum.size();
  const double middle = static_cast<double>(count / 2);
  Transform transform(count);
  std::vector<Complex> shifted = spectrum, samples(count), step(count);
  for (std::size_t m = 0; m < count; ++m) {
    step[m] = std::polar(1.0, 2 * kPi * (static_cast<double>(m) - middle) /
                                  (static_cast<double>(count) * oversampling));
  }
  // One transform gives every oversampling-th instant; then all of time moves on by one.
  std::vector<double> squared(count * oversampling);
  for (int q = 0; q < oversampling; ++q) {
    transform.run(shifted.data(), samples.data());
    for (std::size_t j = 0; j < count; ++j) squared[j * oversampling + q] = std::norm(samples[j]);
    for (std::size_t m = 0; m < count; ++m) shifted[m] = times(shifted[m], step[m]);
  }
  return squared;
}

}  // namespace ensonify
