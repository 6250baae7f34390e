// Standard errors of fitted keys. Private to fit/.
//
//   FitErrors  fit_errors
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fit/linear_model.h"

namespace ensonify {

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
