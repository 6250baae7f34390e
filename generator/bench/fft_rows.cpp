#include "bench/fft_rows.h"

#include <fftw3.h>

#include <algorithm>
#include <cstring>
#include <new>

namespace ensonify {
namespace {

constexpr std::size_t kAlignment = 64;

fftwf_complex* fftw_row(std::complex<float>* row) { return reinterpret_cast<fftwf_complex*>(row); }
fftw_complex* fftw_row(std::complex<double>* row) { return reinterpret_cast<fftw_complex*>(row); }

struct AlignedRow {
  explicit AlignedRow(int length)
      : memory(::operator new(length * sizeof(std::complex<float>), std::align_val_t(kAlignment))),
        data(static_cast<std::complex<float>*>(memory)) {}
  ~AlignedRow() { ::operator delete(memory, std::align_val_t(kAlignment)); }
  AlignedRow(const AlignedRow&) = delete;
  AlignedRow& operator=(const AlignedRow&) = delete;

  void* memory;
  std::complex<float>* data;
};

}  // namespace

FftRows::FftRows(int length, int stride, int rows) : length_(length), stride_(stride), rows_(rows) {
  const std::size_t bytes = std::size_t(rows) * stride * sizeof(std::complex<float>);
  memory_ = ::operator new(bytes, std::align_val_t(kAlignment));
  data_ = static_cast<std::complex<float>*>(memory_);
  const AlignedRow out(length);
  plan_ =
      fftwf_plan_dft_1d(length, fftw_row(data_), fftw_row(out.data), FFTW_BACKWARD, FFTW_MEASURE);
  std::memset(memory_, 0, bytes);
}

FftRows::~FftRows() {
  fftwf_destroy_plan(static_cast<fftwf_plan>(plan_));
  ::operator delete(memory_, std::align_val_t(kAlignment));
}

void FftRows::run(std::complex<float>* out, int samples, const Workers& workers) const {
  workers.for_each(rows_, [&](std::size_t j) {
    const AlignedRow row(length_);
    fftwf_execute_dft(static_cast<fftwf_plan>(plan_), fftw_row(data_ + j * stride_),
                      fftw_row(row.data));
    std::copy(row.data, row.data + samples, out + j * samples);
  });
}

void exact_inverse_transform(std::complex<double>* rows, int length, int count,
                             const Workers& workers) {
  const fftw_plan plan = fftw_plan_dft_1d(length, fftw_row(rows), fftw_row(rows), FFTW_BACKWARD,
                                          FFTW_ESTIMATE | FFTW_UNALIGNED);
  workers.for_each(count, [&](std::size_t j) {
    fftw_complex* row = fftw_row(rows + j * length);
    fftw_execute_dft(plan, row, row);
  });
  fftw_destroy_plan(plan);
}

}  // namespace ensonify
