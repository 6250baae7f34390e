#include "synthesis/beam_mixing.h"

#include <algorithm>

#include "core/sonar.h"

namespace ensonify {
namespace {

// Columns gathered at once, so that each row is read in whole cache lines.
constexpr int kColumnBlock = 8;

}  // namespace

BeamMixer::BeamMixer(const Mixing& mixing)
    : beams_(mixing.beams()),
      scale_(mixing.scale),
      // Twice the fan, so that the circular convolution does not join its two ends.
      forward_(smooth_even_length(2 * beams_), FftDirection::forward),
      backward_(smooth_even_length(2 * beams_), FftDirection::backward) {
  amplitude_matrix_.reserve(mixing.matrix.size());
  power_matrix_.reserve(mixing.matrix.size());
  for (std::size_t at = 0; at < mixing.matrix.size(); ++at) {
    amplitude_matrix_.push_back(scale_[at / scale_.size()] * mixing.matrix[at]);
    power_matrix_.push_back(amplitude_matrix_.back() * amplitude_matrix_.back());
  }
  if (!mixing.is_equal()) return;
  std::vector<double> squared(beams_);
  for (int k = 0; k < beams_; ++k) squared[k] = mixing.weight[k] * mixing.weight[k];
  for (const double s : scale_) power_scale_.push_back(s * s);
  amplitude_spectrum_ = kernel_spectrum(mixing.weight);
  power_spectrum_ = kernel_spectrum(squared);
}

std::vector<double> BeamMixer::kernel_spectrum(const std::vector<double>& weight) const {
  const int length = forward_.length();
  AlignedBuffer<std::complex<double>> kernel(length);
  kernel[0] = weight[0];
  for (int k = 1; k < beams_; ++k) kernel[k] = kernel[length - k] = weight[k];
  forward_.run(kernel.data());
  std::vector<double> spectrum(length);
  for (int k = 0; k < length; ++k) spectrum[k] = kernel[k].real() / length;
  return spectrum;
}

void BeamMixer::convolve(std::complex<double>* column, const std::vector<double>& spectrum) const {
  forward_.run(column);
  for (int k = 0; k < forward_.length(); ++k) column[k] *= spectrum[k];
  backward_.run(column);
}

template <class Value>
void BeamMixer::mix_by_matrix(Value* rows, int columns, int stride,
                              const std::vector<double>& matrix, const Workers& workers) const {
  workers.for_each((columns + kColumnBlock - 1) / kColumnBlock, [&](std::size_t block) {
    const int first = static_cast<int>(block) * kColumnBlock;
    const int count = std::min(kColumnBlock, columns - first);
    std::vector<Value> cells(std::size_t(beams_) * kColumnBlock);
    for (int i = 0; i < beams_; ++i) {
      std::copy_n(rows + std::size_t(i) * stride + first, count,
                  cells.data() + std::size_t(i) * kColumnBlock);
    }
    for (int j = 0; j < beams_; ++j) {
      const double* weight = matrix.data() + std::size_t(j) * beams_;
      Value sum[kColumnBlock] = {};
      for (int i = 0; i < beams_; ++i) {
        const Value* cell = cells.data() + std::size_t(i) * kColumnBlock;
        for (int c = 0; c < kColumnBlock; ++c) sum[c] += weight[i] * cell[c];
      }
      std::copy_n(sum, count, rows + std::size_t(j) * stride + first);
    }
  });
}

void BeamMixer::mix_amplitude(std::complex<double>* rows, int columns, int stride,
                              const Workers& workers) const {
  if (!amplitude_matrix_.empty()) {
    return mix_by_matrix(rows, columns, stride, amplitude_matrix_, workers);
  }
  const int length = forward_.length();
  const int pitch = (length + 3) / 4 * 4;  // keeps every column on a 64-byte boundary
  workers.for_each((columns + kColumnBlock - 1) / kColumnBlock, [&](std::size_t block) {
    const int first = static_cast<int>(block) * kColumnBlock;
    const int count = std::min(kColumnBlock, columns - first);
    AlignedBuffer<std::complex<double>> scratch(std::size_t(pitch) * count);
    for (int j = 0; j < beams_; ++j) {
      const std::complex<double>* row = rows + std::size_t(j) * stride + first;
      for (int c = 0; c < count; ++c) scratch[std::size_t(c) * pitch + j] = row[c];
    }
    for (int c = 0; c < count; ++c) {
      convolve(scratch.data() + std::size_t(c) * pitch, amplitude_spectrum_);
    }
    for (int j = 0; j < beams_; ++j) {
      std::complex<double>* row = rows + std::size_t(j) * stride + first;
      for (int c = 0; c < count; ++c) row[c] = scale_[j] * scratch[std::size_t(c) * pitch + j];
    }
  });
}

void BeamMixer::mix_power(double* rows, int columns, int stride, const Workers& workers) const {
  if (!power_matrix_.empty()) return mix_by_matrix(rows, columns, stride, power_matrix_, workers);
  const int length = forward_.length();
  const int pitch = (length + 3) / 4 * 4;
  // Two real columns share one complex transform, because the kernel's spectrum is real.
  constexpr int kPairs = kColumnBlock / 2;
  workers.for_each((columns + kColumnBlock - 1) / kColumnBlock, [&](std::size_t block) {
    const int first = static_cast<int>(block) * kColumnBlock;
    const int count = std::min(kColumnBlock, columns - first);
    AlignedBuffer<std::complex<double>> scratch(std::size_t(pitch) * kPairs);
    for (int j = 0; j < beams_; ++j) {
      const double* row = rows + std::size_t(j) * stride + first;
      for (int c = 0; c < count; c += 2) {
        scratch[std::size_t(c / 2) * pitch + j] = {row[c], c + 1 < count ? row[c + 1] : 0.0};
      }
    }
    for (int p = 0; p < (count + 1) / 2; ++p) {
      convolve(scratch.data() + std::size_t(p) * pitch, power_spectrum_);
    }
    for (int j = 0; j < beams_; ++j) {
      double* row = rows + std::size_t(j) * stride + first;
      for (int c = 0; c < count; ++c) {
        const std::complex<double> pair = scratch[std::size_t(c / 2) * pitch + j];
        row[c] = power_scale_[j] * (c % 2 == 0 ? pair.real() : pair.imag());
      }
    }
  });
}

}  // namespace ensonify
