// Standard errors of fitted keys. Private to fit/.
//
//   FitErrors  fit_errors   of a linear model, from the blocks of recording and simulation and from
//                           what the model leaves of its simulations
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "fit/linear_model.h"

namespace ensonify {

struct FitErrors {
  Eigen::MatrixXd covariance;  // [keys x keys]
  Eigen::VectorXd curvature;   // [keys]: (H^-1)_kk, the variance if moments were independent
  Eigen::VectorXd quantile;    // [keys]: t at 97.5 %
};

// z-scaled pseudo-values of the used moments, [moments x blocks]. Needs 3 blocks or more of each.
FitErrors fit_errors(const LinearModel& model, const Eigen::MatrixXd& recording,
                     const Eigen::MatrixXd& simulation);

}  // namespace ensonify
