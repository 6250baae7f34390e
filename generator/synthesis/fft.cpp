#include "synthesis/fft.h"

#include <fftw3.h>

#include <cstring>
#include <mutex>
#include <new>

#include "core/error.h"

namespace ensonify {
namespace {

std::mutex*& planner() {
  static std::mutex own;
  static std::mutex* used = &own;
  return used;
}

fftw_complex* as_fftw(std::complex<double>* data) { return reinterpret_cast<fftw_complex*>(data); }

// Measured plans may differ from run to run, which would change the last bits of every result.
constexpr unsigned kPlanFlags = FFTW_ESTIMATE;

void destroy(fftw_plan plan) {
  const std::lock_guard lock(planner_mutex());
  fftw_destroy_plan(plan);
}

}  // namespace

std::mutex& planner_mutex() { return *planner(); }

void share_planner(std::mutex& mutex) { planner() = &mutex; }

void* allocate_zeroed(std::size_t bytes) {
  void* memory = ::operator new (bytes + 1, std::align_val_t{64});
  std::memset(memory, 0, bytes);
  return memory;
}

void FreeAligned::operator()(void* memory) const {
  ::operator delete (memory, std::align_val_t{64});
}

struct FftPlan {
  explicit FftPlan(fftw_plan p) : plan(p) { ENSONIFY_ASSERT(plan != nullptr); }
  ~FftPlan() { destroy(plan); }
  FftPlan(const FftPlan&) = delete;
  FftPlan& operator=(const FftPlan&) = delete;
  fftw_plan plan;
};

ComplexFft::ComplexFft(int length, FftDirection direction) : length_(length) {
  AlignedBuffer<std::complex<double>> scratch(length);
  const int sign = direction == FftDirection::forward ? FFTW_FORWARD : FFTW_BACKWARD;
  const std::lock_guard lock(planner_mutex());
  plan_ = std::make_shared<FftPlan>(
      fftw_plan_dft_1d(length, as_fftw(scratch.data()), as_fftw(scratch.data()), sign, kPlanFlags));
}

void ComplexFft::run(std::complex<double>* data) const {
  fftw_execute_dft(plan_->plan, as_fftw(data), as_fftw(data));
}

BatchFft::BatchFft(int length, int count, FftDirection direction) {
  AlignedBuffer<std::complex<double>> scratch(std::size_t(length) * count);
  fftw_complex* data = as_fftw(scratch.data());
  const int sign = direction == FftDirection::forward ? FFTW_FORWARD : FFTW_BACKWARD;
  const std::lock_guard lock(planner_mutex());
  plan_ = std::make_shared<FftPlan>(fftw_plan_many_dft(1, &length, count, data, nullptr, count, 1,
                                                       data, nullptr, count, 1, sign, kPlanFlags));
}

void BatchFft::run(std::complex<double>* data) const {
  fftw_execute_dft(plan_->plan, as_fftw(data), as_fftw(data));
}

RealFft::RealFft(int length, FftDirection direction) : length_(length), direction_(direction) {
  AlignedBuffer<double> real(length);
  AlignedBuffer<std::complex<double>> half(length / 2 + 1);
  const std::lock_guard lock(planner_mutex());
  plan_ = std::make_shared<FftPlan>(
      direction == FftDirection::forward
          ? fftw_plan_dft_r2c_1d(length, real.data(), as_fftw(half.data()),
                                 kPlanFlags | FFTW_PRESERVE_INPUT)
          : fftw_plan_dft_c2r_1d(length, as_fftw(half.data()), real.data(), kPlanFlags));
}

void RealFft::run(double* real, std::complex<double>* half) const {
  if (direction_ == FftDirection::forward) {
    fftw_execute_dft_r2c(plan_->plan, real, as_fftw(half));
  } else {
    fftw_execute_dft_c2r(plan_->plan, as_fftw(half), real);
  }
}

}  // namespace ensonify
