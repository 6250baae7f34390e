// FFTW in double precision, with plans that any number of threads may run at once.
//
//   AlignedBuffer   memory as FFTW's vector code wants it
//   ComplexFft      in place, forward or backward, unscaled
//   BatchFft        many of them side by side
//   RealFft         real to half-complex and back, unscaled
#pragma once

#include <complex>
#include <cstddef>
#include <memory>

namespace ensonify {

// 64-byte aligned memory of at least one byte. Throws std::bad_alloc.
void* allocate_zeroed(std::size_t bytes);

struct FreeAligned {
  void operator()(void* memory) const;
};

// Zeroed array of n elements on a 64-byte boundary. Throws std::bad_alloc.
template <class T>
class AlignedBuffer {
 public:
  AlignedBuffer() : size_(0) {}
  explicit AlignedBuffer(std::size_t n)
      : size_(n), data_(static_cast<T*>(allocate_zeroed(n * sizeof(T)))) {}
  // At least n elements; what was there is lost where there were fewer.
  void need(std::size_t n) {
    if (size_ < n) *this = AlignedBuffer(n);
  }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return data_.get()[i]; }
  const T& operator[](std::size_t i) const { return data_.get()[i]; }
  T* begin() { return data(); }
  T* end() { return data() + size_; }

 private:
  std::size_t size_;
  std::unique_ptr<T[], FreeAligned> data_;
};

// Real and imaginary parts by turns, as kernels take them.
inline double* as_doubles(std::complex<double>* p) { return reinterpret_cast<double*>(p); }
inline const double* as_doubles(const std::complex<double>* p) {
  return reinterpret_cast<const double*>(p);
}

enum class FftDirection { forward, backward };  // e^(-i...) and e^(+i...)

struct FftPlan;  // of FFTW, destroyed with its last user

class ComplexFft {
 public:
  ComplexFft(int length, FftDirection direction);
  // In place; data as long as the plan, 64-byte aligned.
  void run(std::complex<double>* data) const;
  int length() const { return length_; }

 private:
  int length_;
  std::shared_ptr<const FftPlan> plan_;
};

// data [length][count], transformed along the first.
class BatchFft {
 public:
  BatchFft(int length, int count, FftDirection direction);
  void run(std::complex<double>* data) const;

 private:
  std::shared_ptr<const FftPlan> plan_;
};

class RealFft {
 public:
  RealFft(int length, FftDirection direction);
  // forward: real[length] -> half[length/2 + 1]; real is kept.
  // backward: half -> real; half is overwritten.
  void run(double* real, std::complex<double>* half) const;
  int length() const { return length_; }

 private:
  int length_;
  FftDirection direction_;
  std::shared_ptr<const FftPlan> plan_;
};

}  // namespace ensonify
