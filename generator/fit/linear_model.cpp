#include "fit/linear_model.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "compare/jackknife.h"

namespace ensonify {
namespace {

// Curvature that keeps a key in place that no moment depends on. A key with an error of a twentieth
// of its range has 400 times as much.
constexpr double kHold = 1;

constexpr double kHuber = 3;

}  // namespace

LinearModel regress(const Eigen::MatrixXd& offsets, const Eigen::MatrixXd& z) {
  const Eigen::Index keys = offsets.cols(), points = offsets.rows();
  const bool squares = points >= 2 * (2 * keys + 1);
  Eigen::MatrixXd terms(points, squares ? 2 * keys + 1 : keys + 1);
  terms.col(0).setOnes();
  // Offsets are scaled, because keys may differ by orders of magnitude in what they change.
  const Eigen::VectorXd scale = offsets.cwiseAbs().colwise().maxCoeff().cwiseMax(1e-12);
  for (Eigen::Index k = 0; k < keys; ++k) {
    terms.col(1 + k) = offsets.col(k) / scale(k);
    if (squares) terms.col(1 + keys + k) = terms.col(1 + k).cwiseAbs2();
  }
  const Eigen::MatrixXd solved = terms.colPivHouseholderQr().solve(z);  // [terms x moments]
  LinearModel model;
  model.at_center = solved.row(0).transpose();
  model.jacobian = solved.middleRows(1, keys).transpose() * scale.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse =
      (terms.transpose() * terms).completeOrthogonalDecomposition().pseudoInverse();
  const double freedom = std::max(1.0, static_cast<double>(points - terms.cols()));
  model.scatter = (z - terms * solved).transpose() * std::sqrt(inverse(0, 0) / freedom);
  return model;
}

double huber_loss(const Eigen::VectorXd& z) {
  double sum = 0;
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    const double size = std::abs(z(i));
    sum += size <= kHuber ? size * size : kHuber * (2 * size - kHuber);
  }
  return sum;
}

Eigen::VectorXd huber_weights(const Eigen::VectorXd& z) {
  return z.cwiseAbs().cwiseMax(kHuber).cwiseInverse() * kHuber;
}

Eigen::VectorXd least_step(const LinearModel& model, const StepBox& box) {
  const Eigen::MatrixXd weighted =
      model.jacobian.transpose() * huber_weights(model.at_center).asDiagonal();
  Eigen::MatrixXd hessian = weighted * model.jacobian;
  hessian.diagonal().array() += kHold;
  const Eigen::VectorXd gradient = weighted * model.at_center;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(hessian.rows()).cwiseMax(box.low).cwiseMin(box.high);
  constexpr int kMost = 10000;
  for (int round = 0; round < kMost; ++round) {
    double moved = 0;
    for (Eigen::Index k = 0; k < step.size(); ++k) {
      if (!(hessian(k, k) > 0)) continue;
      const double wanted =
          step(k) - (gradient(k) + hessian.row(k).dot(step)) / hessian(k, k);
      const double now = std::clamp(wanted, box.low(k), box.high(k));
      moved = std::max(moved, std::abs(now - step(k)));
      step(k) = now;
    }
    if (moved < 1e-12) break;
  }
  return step;
}

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
