// FFTW in double precision, with plans that any number of threads may run at once.
//
//   planner_mutex  share_planner
//   AlignedBuffer   memory with the alignment of FFTW's vector code
//   ComplexFft      in place, forward or backward, unscaled
//   BatchFft        many interleaved complex transforms at once
//   RealFft         real to half-complex and back, unscaled
#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <mutex>

namespace ensonify {

// FFTW's planner has global state, so that calls to it hold this mutex. Running a plan does not
// need it. A module has code of its own but the FFTW of the program: it shares the program's mutex
// before its first plan.
std::mutex& planner_mutex();
void share_planner(std::mutex& mutex);

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
  // Provides at least n elements. If the buffer has to grow, its contents are lost.
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

// Interleaved real and imaginary parts, for the kernels.
inline double* as_doubles(std::complex<double>* p) { return reinterpret_cast<double*>(p); }
inline const double* as_doubles(const std::complex<double>* p) {
  return reinterpret_cast<const double*>(p);
}

enum class FftDirection { forward, backward };  // e^(-i...) and e^(+i...)

struct FftPlan;  // a plan of FFTW, destroyed with its last user

class ComplexFft {
 public:
  ComplexFft(int length, FftDirection direction);
  // In place. data: [length()], 64-byte aligned.
  void run(std::complex<double>* data) const;
  int length() const { return length_; }

 private:
  int length_;
  std::shared_ptr<const FftPlan> plan_;
};

// Transforms data [length][count] along the first dimension.
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
  // forward: real[length] -> half[length/2 + 1]; keeps real.
  // backward: half -> real; overwrites half.
  void run(double* real, std::complex<double>* half) const;
  int length() const { return length_; }

 private:
  int length_;
  FftDirection direction_;
  std::shared_ptr<const FftPlan> plan_;
};

}  // namespace ensonify
