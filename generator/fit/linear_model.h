// Regression of moments on keys, steps in it, and the standard errors of the fitted keys. Private
// to fit/.
//
//   LinearModel  regress  StepBox  least_step
//   huber_loss  huber_weights   of moments in units of their errors
//   FitErrors  fit_errors       of the keys
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

struct FitErrors {
  Eigen::MatrixXd covariance;  // [keys x keys]
  Eigen::VectorXd curvature;   // [keys]: (H^-1)_kk, the variance if moments were independent
  Eigen::VectorXd quantile;    // [keys]: t at 97.5 %
};

// Delete-one jackknife of the step to the minimum of the linear model: for each block of the
// recording, and of the simulation, the moments, their errors and Huber's weights follow from the
// other blocks. Errors of a few blocks are uncertain themselves, and weights that follow from them
// scatter more than those of known errors; this counts it. What the model leaves of its simulations
// is added. z-scaled pseudo-values of the used moments, [moments x blocks]. Needs 3 blocks or more
// of each.
FitErrors fit_errors(const LinearModel& model, const Eigen::MatrixXd& recording,
                     const Eigen::MatrixXd& simulation);

}  // namespace ensonify
