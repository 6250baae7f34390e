// Samples of an inertial measurement unit on the body.
//
//   ImuErrors      noise and biases, sample by sample
//   simulate_imu   rows of imu.csv and imu_truth.csv
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/navigation.h"
#include "navigation/course.h"

namespace ensonify {

// Errors of the six axes: rates x, y, z in rad/s, then specific force x, y, z in m/s^2.
//   error_k = white_k + bias_k
//   bias_k  = constant + walk_k + flicker_k
// White noise has the standard deviation N sqrt(rate), the walk grows by K sqrt(1/rate) with each
// sample. Flicker noise is the sum of first-order Gauss-Markov processes with correlation times
// 4^i / 64 s, from one sample to 4.6 h, each with the standard deviation B: their spectrum is
// B^2 / (2 ln 2 f) within 0.4 %, whose Allan deviation is B (IEEE Std 952, C.1.3).
class ImuErrors {
 public:
  using Axes = std::array<double, 6>;
  ImuErrors(const Imu& imu, std::uint64_t key);

  // Moves on to sample 0, 1, ...
  void next();
  const Axes& error() const { return error_; }
  const Axes& bias() const { return bias_; }

 private:
  struct Process {
    double keep = 0, add = 0;  // x_k+1 = keep x_k + add B xi
    Axes value{};
  };

  std::uint64_t key_;
  std::uint64_t sample_ = 0;
  Axes white_{}, walk_step_{}, flicker_{}, constant_{}, walk_{};
  std::vector<Process> processes_;
  Axes error_{}, bias_{};
};

// Sample k is the mean angular rate over the time from t_k - T/2 to t_k + T/2, T = 1/rate, and the
// mean specific force: with positions p and attitudes q of the path
//   w_k = log(q(t_k - T/2)^-1 q(t_k + T/2)) / T
//   f_k = R(q(t_k - T/2) exp(w_k T/2))^-1 ((p(t_k+1) - 2 p(t_k) + p(t_k-1)) / T^2 + g e_z)
// so that these sums give positions and attitudes of the path back without an error, also where
// it has corners:
//   q <- q exp(w_k T),  v <- v + (R f_k - g e_z) T,  p(t_k+1) = p(t_k) + v T
// Rows of `truth` are the states where the samples begin, and where the last one ends: pose of the
// path, velocity (p(t_k) - p(t_k-1)) / T, and the biases. Where the body moves, samples whose
// differences reach beyond the ends of the path are left out.
void simulate_imu(const Imu& imu, const Course& course, const EmitRow& samples,
                  const EmitRow& truth);

}  // namespace ensonify
