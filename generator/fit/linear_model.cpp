#include "fit/linear_model.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

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

}  // namespace ensonify
