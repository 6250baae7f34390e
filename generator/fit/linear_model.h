// Regression of moments on keys, and steps in it. Private to fit/.
//
//   LinearModel  regress  least_step  StepBox
#pragma once

#include <Eigen/Dense>
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

// The step s with the least |at_center + jacobian s|^2 in the box, by cyclic descent.
Eigen::VectorXd least_step(const LinearModel& model, const StepBox& box);

}  // namespace ensonify
