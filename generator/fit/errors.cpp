#include "fit/errors.h"

#include <boost/math/distributions/students_t.hpp>

namespace ensonify {
namespace {

// Of the mean of the columns of `influence * pseudo`.
Eigen::MatrixXd covariance_of_mean(const Eigen::MatrixXd& influence,
                                   const Eigen::MatrixXd& pseudo) {
  const Eigen::MatrixXd moved = influence * pseudo;  // [keys x blocks]
  const Eigen::MatrixXd centered = moved.colwise() - moved.rowwise().mean();
  const auto blocks = static_cast<double>(pseudo.cols());
  return centered * centered.transpose() / (blocks * (blocks - 1));
}

}  // namespace

FitErrors fit_errors(const LinearModel& model, const Eigen::MatrixXd& recording,
                     const Eigen::MatrixXd& simulation) {
  const Eigen::MatrixXd& g = model.jacobian;
  const Eigen::MatrixXd weighted = g.transpose() * huber_weights(model.at_center).asDiagonal();
  Eigen::MatrixXd hessian = weighted * g;
  // The inverse must exist where a key has no influence; what the ridge hides is that the key may be
  // anywhere in its range.
  constexpr double kRidge = 1e-4;
  hessian.diagonal().array() += kRidge;
  const Eigen::MatrixXd inverse = hessian.inverse();
  const Eigen::MatrixXd hidden = kRidge * inverse;
  const Eigen::MatrixXd influence = inverse * weighted;
  const Eigen::MatrixXd a = covariance_of_mean(influence, recording);
  const Eigen::MatrixXd b = covariance_of_mean(influence, simulation);
  const Eigen::MatrixXd rough = influence * model.scatter;
  FitErrors errors{a + b + rough * rough.transpose() + hidden * hidden.transpose(), inverse.diagonal(), Eigen::VectorXd(g.cols())};
  // A moment of exact values, such as a number of bits, may leave no scatter at all.
  errors.covariance.diagonal() = errors.covariance.diagonal().cwiseMax(1e-12);
  const auto freedom_a = static_cast<double>(recording.cols() - 1);
  const auto freedom_b = static_cast<double>(simulation.cols() - 1);
  for (Eigen::Index k = 0; k < g.cols(); ++k) {
    const double va = a(k, k), vb = b(k, k), sum = va + vb;
    const double parts = va * va / freedom_a + vb * vb / freedom_b;
    const double freedom = parts > 0 ? sum * sum / parts : freedom_a;
    errors.quantile(k) = boost::math::quantile(boost::math::students_t(freedom), 0.975);
  }
  return errors;
}

}  // namespace ensonify
