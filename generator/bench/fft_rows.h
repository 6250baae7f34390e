// Transforms of many rows by FFTW, apart from those of the backends.
//
//   FftRows                   single precision, with its own memory: the plain methods'
//   exact_inverse_transform   double precision: the exact series'
#pragma once

#include <complex>
#include <cstddef>

#include "core/parallel.h"

namespace ensonify {

// e^(+i...), unscaled, with the plan that FFTW measures to be the fastest. Made by one thread at a
// time.
class FftRows {
 public:
  FftRows(int length, int stride, int rows);
  ~FftRows();
  FftRows(const FftRows&) = delete;
  FftRows& operator=(const FftRows&) = delete;

  // The first `samples` of the transform of each row; out: [rows x samples].
  void run(std::complex<float>* out, int samples, const Workers& workers) const;
  // [rows x stride], zero at first, on a 64-byte boundary.
  std::complex<float>* data() const { return data_; }

 private:
  int length_, stride_, rows_;
  void* memory_;
  std::complex<float>* data_;
  void* plan_;
};

// rows: [count x length].
void exact_inverse_transform(std::complex<double>* rows, int length, int count,
                             const Workers& workers);

}  // namespace ensonify
