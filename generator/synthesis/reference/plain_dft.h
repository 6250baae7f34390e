// Discrete Fourier transforms of 2-3-5-smooth lengths by the definition's factors alone, so that
// the oracle shares no transform with what it judges.
#pragma once

#include <complex>
#include <vector>

#include "core/units.h"

namespace ensonify {

class PlainDft {
 public:
  using Complex = std::complex<double>;

  explicit PlainDft(int length) : length_(length) {
    for (int k = 0; k < length; ++k) turn_.push_back(std::polar(1.0, 2 * kPi * k / length));
  }

  // X_k = sum_n x_n e^(i 2 pi k n / length).
  std::vector<Complex> operator()(const std::vector<Complex>& x) const {
    std::vector<Complex> out(x.size());
    sum(x.data(), 1, out.data(), length_);
    return out;
  }

 private:
  // Of every `stride`-th value, `count` of them.
  void sum(const Complex* x, int stride, Complex* out, int count) const {
    if (count == 1) {
      *out = *x;
      return;
    }
    int factor = 2;
    while (count % factor != 0) ++factor;
    const int part = count / factor, step = length_ / count;
    for (int r = 0; r < factor; ++r) sum(x + r * stride, stride * factor, out + r * part, part);
    std::vector<Complex> one(factor);
    for (int k = 0; k < part; ++k) {
      for (int r = 0; r < factor; ++r) one[r] = out[r * part + k];
      for (int s = 0; s < factor; ++s) {
        const long index = k + s * part;
        Complex value = one[0];
        for (int r = 1; r < factor; ++r) value += one[r] * turn_[r * index % count * step];
        out[index] = value;
      }
    }
  }

  int length_;
  std::vector<Complex> turn_;
};

}  // namespace ensonify
