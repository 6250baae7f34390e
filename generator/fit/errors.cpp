#include "fit/errors.h"

#include <Eigen/LU>

#include "compare/jackknife.h"

namespace ensonify {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

// The inverse of H must exist where a key has no influence.
constexpr double kRidge = 1e-4;

struct Step {
  Matrix inverse;    // of H
  Matrix influence;  // [keys x moments]: the step is -influence z
};

Step step_of(const Matrix& jacobian, const Vector& z, const Vector& weight) {
  const Vector scaled = z.array() * weight.array().sqrt();
  const Vector all = weight.array() * huber_weights(scaled).array();
  const Matrix weighted = jacobian.transpose() * all.asDiagonal();
  Matrix hessian = weighted * jacobian;
  hessian.diagonal().array() += kRidge;
  Step step;
  step.inverse = hessian.inverse();
  step.influence = step.inverse * weighted;
  return step;
}

// Squared errors of the means over the blocks.
Vector squared_errors(const Matrix& pseudo) {
  const auto blocks = static_cast<double>(pseudo.cols());
  const Matrix centered = pseudo.colwise() - pseudo.rowwise().mean();
  return centered.rowwise().squaredNorm() / (blocks * (blocks - 1));
}

Matrix without(const Matrix& pseudo, Eigen::Index block) {
  Matrix rest(pseudo.rows(), pseudo.cols() - 1);
  rest << pseudo.leftCols(block), pseudo.rightCols(pseudo.cols() - block - 1);
  return rest;
}

// Of the step, if each block in turn is left out. `other`: the squared errors of the other data
// set; `sign`: 1 for the simulation, -1 for the recording.
Matrix jackknife_of(const LinearModel& model, const Matrix& pseudo, const Vector& other,
                    double sign) {
  const Eigen::Index blocks = pseudo.cols();
  const Vector mean = pseudo.rowwise().mean();
  // All errors are 1 in units of sigma; the rest is what keeps exact moments from deciding alone.
  const Vector rest =
      (Vector::Ones(mean.size()) - squared_errors(pseudo) - other).cwiseMax(0.0);
  Matrix steps(model.jacobian.cols(), blocks);
  for (Eigen::Index b = 0; b < blocks; ++b) {
    const Matrix kept = without(pseudo, b);
    const Vector z = model.at_center + sign * (kept.rowwise().mean() - mean);
    const Vector weight = (squared_errors(kept) + other + rest).cwiseMax(1e-3).cwiseInverse();
    steps.col(b) = -step_of(model.jacobian, z, weight).influence * z;
  }
  const Matrix centered = steps.colwise() - steps.rowwise().mean();
  const auto count = static_cast<double>(blocks);
  return centered * centered.transpose() * ((count - 1) / count);
}

}  // namespace

FitErrors fit_errors(const LinearModel& model, const Matrix& recording, const Matrix& simulation) {
  const Step whole = step_of(model.jacobian, model.at_center, Vector::Ones(model.at_center.size()));
  const Matrix a = jackknife_of(model, recording, squared_errors(simulation), -1);
  const Matrix b = jackknife_of(model, simulation, squared_errors(recording), 1);
  const Matrix rough = whole.influence * model.scatter;
  // The ridge hides that a key without influence may be anywhere in its range.
  const Matrix hidden = kRidge * whole.inverse;
  FitErrors errors{a + b + rough * rough.transpose() + hidden * hidden.transpose(),
                   whole.inverse.diagonal(), Vector(model.jacobian.cols())};
  // A moment of exact values, such as a number of bits, may leave no scatter at all.
  errors.covariance.diagonal() = errors.covariance.diagonal().cwiseMax(1e-12);
  const auto freedom_a = static_cast<double>(recording.cols() - 1);
  const auto freedom_b = static_cast<double>(simulation.cols() - 1);
  for (Eigen::Index k = 0; k < errors.quantile.size(); ++k) {
    const double freedom = a(k, k) + b(k, k) > 0
                               ? welch_freedom(a(k, k), freedom_a, b(k, k), freedom_b)
                               : freedom_a;
    errors.quantile(k) = t_quantile(0.975, freedom);
  }
  return errors;
}

}  // namespace ensonify
