#include "fit/search.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "fit/linear_model.h"

namespace ensonify {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

constexpr double kFirstRadius = 0.25, kLeastRadius = 0.03, kMostRadius = 0.2;
constexpr double kMissing = 5;         // |z| of a moment that a simulation lacks
constexpr double kDefinedShare = 0.8;  // of the first design, for a moment to be used
constexpr double kLeastError = 1e-3;  // relative to the largest of a moment's values
constexpr int kMostSteps = 30;

double halton(std::size_t index, int dimension) {
  constexpr int kPrimes[kMostFitKeys] = {2,  3,  5,  7,  11, 13, 17, 19,
                                         23, 29, 31, 37, 41, 43, 47, 53};
  const int base = kPrimes[dimension];
  double value = 0, part = 1.0 / base;
  for (std::size_t i = index + 1; i > 0; i /= static_cast<std::size_t>(base)) {
    value += part * static_cast<double>(i % static_cast<std::size_t>(base));
    part /= base;
  }
  return value;
}

struct Point {
  Vector u;
  MomentSample sample;
  double misfit = 0;  // J
};

// All that the search knows.
struct Search {
  std::span<const FitKey> keys;
  const FitTarget& target;
  const FitSettings& settings;
  const Simulate& simulate;
  std::vector<Point> points = {};
  std::vector<std::size_t> used = {};  // moments
  Vector sigma = {};                   // [used]
  std::size_t drawn = 0;               // of the Halton sequence
  int evaluations = 0;

  Eigen::Index size() const { return static_cast<Eigen::Index>(keys.size()); }
};

Vector scaled(const Search& search, const MomentSample& sample) {
  Vector z(static_cast<Eigen::Index>(search.used.size()));
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    const std::size_t m = search.used[static_cast<std::size_t>(i)];
    const double value = sample.value[m];
    z(i) = std::isnan(value) ? kMissing
                             : (value - search.target.value[m]) / search.sigma(i);
  }
  return z;
}

// The place of the point; simulates it unless it is known.
Result<std::size_t> evaluate(Search& search, const Vector& u) {
  for (std::size_t i = 0; i < search.points.size(); ++i) {
    if (search.points[i].u == u) return i;
  }
  std::vector<double> values;
  for (std::size_t k = 0; k < search.keys.size(); ++k) {
    values.push_back(key_value(search.keys[k], u(static_cast<Eigen::Index>(k))));
  }
  Result<MomentSample> sample = search.simulate(values);
  if (!sample) return sample.error();
  ++search.evaluations;
  Point point{u, std::move(*sample), 0};
  if (!search.used.empty()) point.misfit = huber_loss(scaled(search, point.sample));
  search.points.push_back(std::move(point));
  return search.points.size() - 1;
}

Vector next_of_design(Search& search, const Vector& low, const Vector& high) {
  Vector u(search.size());
  for (Eigen::Index k = 0; k < u.size(); ++k) {
    u(k) = low(k) + halton(search.drawn, static_cast<int>(k)) * (high(k) - low(k));
  }
  ++search.drawn;
  return u;
}

// The moments that recording and simulations define, and their errors.
void choose_moments(Search& search) {
  for (std::size_t m = 0; m < search.target.value.size(); ++m) {
    if (std::isnan(search.target.value[m])) continue;
    std::vector<double> errors;
    double largest = std::abs(search.target.value[m]);
    for (const Point& point : search.points) {
      if (std::isnan(point.sample.value[m])) continue;
      errors.push_back(point.sample.error[m]);
      largest = std::max(largest, std::abs(point.sample.value[m]));
    }
    const auto count = static_cast<double>(errors.size());
    if (count < kDefinedShare * static_cast<double>(search.points.size()) || largest == 0) continue;
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    const double sigma = std::hypot(search.target.error[m], *middle);
    search.used.push_back(m);
    search.sigma.conservativeResize(search.sigma.size() + 1);
    search.sigma(search.sigma.size() - 1) = std::max(sigma, kLeastError * largest);
  }
  for (Point& point : search.points) point.misfit = huber_loss(scaled(search, point.sample));
}

std::size_t best_of(const Search& search) {
  const auto less = [](const Point& a, const Point& b) { return a.misfit < b.misfit; };
  return static_cast<std::size_t>(
      std::min_element(search.points.begin(), search.points.end(), less) - search.points.begin());
}

StepBox box_around(const Vector& center, const Vector& radius) {
  const Vector zero = Vector::Zero(center.size()), one = Vector::Ones(center.size());
  return {(center - radius).cwiseMax(zero), (center + radius).cwiseMin(one)};
}

// A linear model from at least `least` simulations within the radius of the center.
Result<LinearModel> model_around(Search& search, const Vector& center, const Vector& radius,
                                 std::size_t least) {
  const StepBox box = box_around(center, radius);
  const auto inside = [&](const Vector& u) {
    constexpr double kRounding = 1e-9;
    return ((u - box.low).array() >= -kRounding).all() &&
           ((box.high - u).array() >= -kRounding).all();
  };
  const auto near = [&] {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < search.points.size(); ++i) {
      if (inside(search.points[i].u)) found.push_back(i);
    }
    return found;
  };
  std::vector<std::size_t> found = near();
  while (found.size() < least) {
    const auto made = evaluate(search, next_of_design(search, box.low, box.high));
    if (!made) return made.error();
    found = near();
  }
  Matrix offsets(static_cast<Eigen::Index>(found.size()), search.size());
  Matrix z(offsets.rows(), search.sigma.size());
  for (Eigen::Index i = 0; i < offsets.rows(); ++i) {
    const Point& point = search.points[found[static_cast<std::size_t>(i)]];
    offsets.row(i) = (point.u - center).transpose();
    z.row(i) = scaled(search, point.sample).transpose();
  }
  return regress(offsets, z);
}

// Of the used moments, in units of sigma.
Matrix scaled_pseudo(const Search& search, const MomentSample& sample) {
  const auto blocks = static_cast<Eigen::Index>(sample.pseudo.front().size());
  Matrix pseudo(search.sigma.size(), blocks);
  for (Eigen::Index i = 0; i < pseudo.rows(); ++i) {
    const std::size_t m = search.used[static_cast<std::size_t>(i)];
    for (Eigen::Index b = 0; b < blocks; ++b) {
      const double value = sample.pseudo[m][static_cast<std::size_t>(b)];
      pseudo(i, b) = std::isnan(value) ? 0 : value / search.sigma(i);
    }
  }
  return pseudo;
}

FitErrors errors_at(const Search& search, const LinearModel& model, std::size_t point) {
  return fit_errors(model, scaled_pseudo(search, search.target),
                    scaled_pseudo(search, search.points[point].sample));
}

// Wide enough that slopes stand out from statistics that jump a little from one simulation to the
// next: slopes of jumps would pass for information about the keys.
Vector radius_of(const FitErrors& errors) {
  return (3 * errors.covariance.diagonal().cwiseSqrt()).cwiseMax(kLeastRadius).cwiseMin(kMostRadius);
}

// Gauss-Newton steps until the trust region is as small as the errors.
Result<std::size_t> descend(Search& search) {
  std::size_t center = best_of(search);
  Vector radius = Vector::Constant(search.size(), kFirstRadius);
  const auto least = static_cast<std::size_t>(2 * search.size() + 2);
  for (int step = 0; step < kMostSteps; ++step) {
    if (search.evaluations >= search.settings.max_evaluations) break;
    const Vector at = search.points[center].u;
    const auto model = model_around(search, at, radius, least);
    if (!model) return model.error();
    const StepBox box = box_around(at, radius);
    const Vector s = least_step(*model, {box.low - at, box.high - at});
    const auto tried = evaluate(search, at + s);
    if (!tried) return tried.error();
    const Vector floor = radius_of(errors_at(search, *model, center));
    const bool was_least = (radius.array() <= floor.array() * 1.001).all();
    const bool reached_edge = ((s.cwiseAbs() - radius).array() >= -1e-9).any();
    const double before = search.points[center].misfit;
    const double expected = huber_loss(model->at_center + model->jacobian * s);
    const bool as_expected =
        before - search.points[*tried].misfit > 0.5 * (before - expected) && expected < before;
    center = best_of(search);
    if (was_least && !reached_edge) break;
    if (!as_expected) {
      radius /= 2;
    } else if (!reached_edge) {
      radius = radius.cwiseMin(2 * s.cwiseAbs());
    }
    radius = radius.cwiseMax(floor);
  }
  return center;
}

struct Settled {
  Vector u;
  std::size_t point = 0;  // the simulation there
  LinearModel model;
  FitErrors errors;
  bool converged = false;
};

// The minimum of models of many simulations within the errors.
Result<Settled> settle(Search& search, std::size_t center) {
  const auto least = static_cast<std::size_t>(6 * search.size() + 6);
  constexpr int kRounds = 4;
  std::optional<Settled> settled;
  Vector radius = Vector::Constant(search.size(), kMostRadius);
  {
    const Vector at = search.points[center].u;
    const auto rough = model_around(search, at, radius, least);
    if (!rough) return rough.error();
    radius = radius_of(errors_at(search, *rough, center));
  }
  for (int round = 0; round < kRounds; ++round) {
    const Vector at = search.points[center].u;
    auto model = model_around(search, at, radius, least);
    if (!model) return model.error();
    const StepBox box = box_around(at, radius);
    const Vector s = least_step(*model, {box.low - at, box.high - at});
    const auto there = evaluate(search, at + s);
    if (!there) return there.error();
    FitErrors errors = errors_at(search, *model, *there);
    const Vector error = errors.covariance.diagonal().cwiseSqrt();
    const bool is_short = (s.cwiseAbs().array() <= error.array()).all();
    settled = Settled{at + s, *there, std::move(*model), std::move(errors), is_short};
    center = *there;
    radius = radius_of(settled->errors);
    if (is_short || search.evaluations >= search.settings.max_evaluations) break;
  }
  return std::move(*settled);
}

// The others' minimum with key k held `offset` from the fit.
Vector conditional(const Settled& settled, Eigen::Index k, double offset) {
  const Matrix& g = settled.model.jacobian;
  Matrix hessian = g.transpose() * huber_weights(settled.model.at_center).asDiagonal() * g;
  hessian.diagonal().array() += 1e-4;
  const Vector column = hessian.inverse().col(k);
  const Vector step = column * (offset / column(k));
  return (settled.u + step).cwiseMax(Vector::Zero(step.size())).cwiseMin(Vector::Ones(step.size()));
}

Result<std::vector<DeviancePoint>> profile_of(Search& search, const Settled& settled,
                                             Eigen::Index k) {
  const double variance = settled.errors.covariance(k, k);
  const double scale = settled.errors.curvature(k) / variance;
  const double least = search.points[settled.point].misfit;
  std::vector<DeviancePoint> profile;
  for (const double f : {-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0}) {
    const double wanted = settled.u(k) + f * std::sqrt(variance);
    if (wanted < 0 || wanted > 1) continue;
    const auto there = f == 0 ? Result<std::size_t>(settled.point)
                              : evaluate(search, conditional(settled, k, f * std::sqrt(variance)));
    if (!there) return there.error();
    profile.push_back({key_value(search.keys[static_cast<std::size_t>(k)], wanted),
                       scale * (search.points[*there].misfit - least)});
  }
  return profile;
}

FittedKey fitted_key(const FitKey& key, const Settled& settled, Eigen::Index k) {
  const double u = settled.u(k), error = std::sqrt(settled.errors.covariance(k, k));
  const double half = settled.errors.quantile(k) * error;
  FittedKey fitted;
  fitted.value = key_value(key, u);
  fitted.low = key_value(key, u - half);
  fitted.high = key_value(key, u + half);
  fitted.error = (key_value(key, u + error) - key_value(key, u - error)) / 2;
  fitted.identified = half < 0.25 && u - half > 0 && u + half < 1;
  return fitted;
}

Result<Fit> described(Search& search, const Settled& settled) {
  Fit fit;
  fit.moments = search.used.size();
  fit.converged = settled.converged;
  const MomentSample& sample = search.points[settled.point].sample;
  fit.misfit = std::sqrt(scaled(search, sample).squaredNorm() / static_cast<double>(fit.moments));
  fit.simulated = sample.value;
  fit.used.assign(search.target.value.size(), false);
  for (const std::size_t m : search.used) fit.used[m] = true;
  const Matrix& covariance = settled.errors.covariance;
  for (Eigen::Index i = 0; i < search.size(); ++i) {
    fit.keys.push_back(fitted_key(search.keys[static_cast<std::size_t>(i)], settled, i));
    for (Eigen::Index j = 0; j < search.size(); ++j) {
      fit.correlation.push_back(covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j)));
    }
  }
  for (Eigen::Index k = 0; k < search.size() && search.settings.profiles; ++k) {
    auto profile = profile_of(search, settled, k);
    if (!profile) return profile.error();
    fit.keys[static_cast<std::size_t>(k)].profile = std::move(*profile);
  }
  fit.evaluations = static_cast<std::size_t>(search.evaluations);
  return fit;
}

}  // namespace

double key_value(const FitKey& key, double u) {
  // Rounding must not leave a range that the scenario accepts.
  if (u == 0) return key.low;
  if (u == 1) return key.high;
  if (key.log) return key.low * std::pow(key.high / key.low, u);
  return key.low + u * (key.high - key.low);
}

Result<Fit> fit_keys(std::span<const FitKey> keys, const FitTarget& target,
                     const FitSettings& settings, const Simulate& simulate) {
  ENSONIFY_ASSERT(!keys.empty() && keys.size() <= kMostFitKeys && !target.pseudo.empty() && target.pseudo.front().size() >= 3);
  Search search{keys, target, settings, simulate};
  const Vector zero = Vector::Zero(search.size()), one = Vector::Ones(search.size());
  for (Eigen::Index i = 0; i < 6 * search.size() + 6; ++i) {
    const auto made = evaluate(search, next_of_design(search, zero, one));
    if (!made) return made.error();
  }
  choose_moments(search);
  if (search.used.size() < keys.size()) {
    return Error{ErrorKind::usage, "recording and simulation have fewer statistics in common than "
                                   "keys to fit; expected more pings, or fewer keys"};
  }
  const auto center = descend(search);
  if (!center) return center.error();
  auto settled = settle(search, *center);
  if (!settled) return settled.error();
  return described(search, *settled);
}

}  // namespace ensonify
