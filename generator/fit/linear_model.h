// Regression of moments on keys, and steps in it. Private to fit/.
//
//   LinearModel  regress  StepBox  least_step
//   huber_loss  huber_weights   of moments in units of their errors
#pragma once

#include <Eigen/Core>
#include <vector>

namespace ensonify {

struct LinearModel {
  Eigen::VectorXd at_center;  // [moments]
  Eigen::MatrixXd jacobian;   // [moments x keys]
  // [moments x points], what the terms leave, scaled so that the covariance of at_center is
  // scatter scatter^T.
  Eigen::MatrixXd scatter;
};

// Least squares of z on offsets from the center, with squares of the offsets if there are at least
// twice as many points as terms, so that curvature does not shift the value at the center.
// offsets [points x keys], z [points x moments]. Needs more points than keys + 1.
LinearModel regress(const Eigen::MatrixXd& offsets, const Eigen::MatrixXd& z);

struct StepBox {
  Eigen::VectorXd low, high;
};

// Huber, "Robust estimation of a location parameter" (1964): z^2 up to |z| = 3, and 6 |z| - 9 beyond,
// so that a few statistics that a model cannot give do not decide about its keys.
double huber_loss(const Eigen::VectorXd& z);
// min(1, 3/|z|).
Eigen::VectorXd huber_weights(const Eigen::VectorXd& z);

// The step s in the box with the least sum_i w_i (at_center + jacobian s)_i^2, by cyclic descent; w
// are the weights of at_center.
Eigen::VectorXd least_step(const LinearModel& model, const StepBox& box);

}  // namespace ensonify
