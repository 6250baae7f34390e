// Fits keys of a simulation to measured statistics, by simulation alone.
//
//   FitKey  key_value                a key and its range
//   MomentSample  FitTarget          statistics of a simulation and of the recording
//   FitSettings  DeviancePoint  FittedKey  Fit
//   fit_keys                         the search
//
// Method of simulated moments (McFadden, Econometrica 57, 1989; Pakes and Pollard, Econometrica 57,
// 1989): minimize J(u) = sum_i rho(z_i(u)), rho Huber's loss and z_i = (m_i(u) - m_i)/sigma_i, for
// the moments m_i of the recording and sigma_i^2 the sum of the squared errors of recording and
// simulation. u is the place of each key in its range, 0 to 1. All simulations use the same random
// numbers, so that J is smooth.
//
// Search: Gauss-Newton steps in a trust region, with the Jacobian G from a regression on the
// simulations in that region (Cartis and Roberts, Math. Prog. Comp. 11, 2019), which averages over
// what noise is left. It begins at the best of a Halton design over the ranges.
//
// Errors: with H = G^T W G and W the weights of Huber's loss, u - u_true = H^-1 G^T W (z_recording -
// z_simulation) to first order. Its covariance follows by leaving out each block of either in turn,
// so that moments may be correlated as they like. Intervals are Student's, with Welch's degrees of
// freedom.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"

namespace ensonify {

struct FitKey {
  std::string path;
  double low = 0, high = 1;
  bool log = false;  // the place in the range is that of the logarithm
};

inline constexpr std::size_t kMostFitKeys = 16;

double key_value(const FitKey& key, double u);

// [moments], NaN where one is not defined; pseudo-values are [moments][blocks].
struct MomentSample {
  std::vector<double> value, error;
  std::vector<std::vector<double>> pseudo;
};
using FitTarget = MomentSample;

struct FitSettings {
  int max_evaluations = 400;  // after which the search takes no further step
  bool profiles = true;
};

// J with the key held at `value` and the others where the linear model has its minimum, less the
// least J, scaled so that a change of f standard errors has f^2.
struct DeviancePoint {
  double value = 0, deviance = 0;
};

struct FittedKey {
  double value = 0, error = 0, low = 0, high = 0;  // the 95 % interval
  // The interval is shorter than half of the range and ends inside it.
  bool identified = false;
  std::vector<DeviancePoint> profile;  // by value; empty without profiles
};

struct Fit {
  std::vector<FittedKey> keys;
  // [keys x keys], row-major: of the errors.
  std::vector<double> correlation;
  std::size_t moments = 0;      // used, of those given
  double misfit = 0;  // root mean square of z at the fit
  std::size_t evaluations = 0;
  bool converged = false;       // the last step was no longer than a standard error
  std::vector<bool> used;       // [moments]
  std::vector<double> simulated;  // [moments] at the fit
};

// Values of the keys to the moments of a simulation. Values of equal bits give equal moments.
using Simulate = std::function<Result<MomentSample>(std::span<const double>)>;

// Needs 1 to kMostFitKeys keys, low < high, and 3 blocks or more. Errors: those of `simulate`; (usage) fewer
// defined moments than keys.
Result<Fit> fit_keys(std::span<const FitKey> keys, const FitTarget& target,
                     const FitSettings& settings, const Simulate& simulate);

}  // namespace ensonify
