#include "synthesis/cpu/beam_nodes.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/compile_targets.h"
#include "synthesis/cpu/beam_fit.h"

namespace ensonify {
namespace {

// The places of equal beams, about the middle of the fan.
std::vector<double> equal_places(int beams) {
  std::vector<double> places;
  for (int j = 0; j < beams; ++j) places.push_back(j - (beams - 1) / 2.0);
  return places;
}

double error_of(const BeamNodes& nodes, const std::vector<double>& weight, double tolerance) {
  const std::vector<double> importance(nodes.beams, 1.0);
  const LeastSquares fit(nodes, tolerance, importance);
  double worst = 0;
  for (const int column : {0, 1, 2, nodes.beams / 7, nodes.beams / 3, nodes.beams / 2}) {
    const auto w = [&](int j) { return weight[std::abs(j - column)]; };
    const std::vector<double> x = fit.solve(w);
    double error = 0, norm = 0;
    for (int j = 0; j < nodes.beams; ++j) {
      double sum = -w(j);
      for (int a = 0; a < nodes.width; ++a) {
        sum += nodes.weight[std::size_t(j) * nodes.width + a] * x[nodes.first[j] + a];
      }
      error += sum * sum;
      norm += w(j) * w(j);
    }
    // The factor is 2 because P on the left and P^T on the right of K each contribute this error.
    worst = std::max(worst, std::sqrt(2 * error / norm));
  }
  return worst;
}

constexpr int kLanes = 8;  // fits at once, so that their operations need not wait for each other

// LeastSquares::solve for `right` [beams][kLanes], with the same operations on each.
ENSONIFY_VECTOR_CLONES void solve_lanes(const BeamNodes& p, const double* __restrict factor,
                                        const double* __restrict right, double* __restrict x) {
  for (int j = 0; j < p.beams; ++j) {
    const double* v = right + std::size_t(j) * kLanes;
    for (int a = 0; a < p.width; ++a) {
      const double w = p.weight[std::size_t(j) * p.width + a];
      double* to = x + std::size_t(p.first[j] + a) * kLanes;
      for (int r = 0; r < kLanes; ++r) to[r] += w * v[r];
    }
  }
  const int band = p.width;
  const auto subtract = [&](int i, int l, double f) {
    const double* other = x + std::size_t(l) * kLanes;
    double* own = x + std::size_t(i) * kLanes;
    for (int r = 0; r < kLanes; ++r) own[r] -= f * other[r];
  };
  const auto divide = [&](int i) {
    for (int r = 0; r < kLanes; ++r)
      x[std::size_t(i) * kLanes + r] /= factor[std::size_t(i) * band];
  };
  for (int i = 0; i < p.nodes; ++i) {
    for (int l = std::max(0, i - band + 1); l < i; ++l) {
      subtract(i, l, factor[std::size_t(i) * band + (i - l)]);
    }
    divide(i);
  }
  for (int i = p.nodes - 1; i >= 0; --i) {
    for (int l = i + 1; l < std::min(p.nodes, i + band); ++l) {
      subtract(i, l, factor[std::size_t(l) * band + (l - i)]);
    }
    divide(i);
  }
}

// Fits the node values of `count` functions; visit(i, c, value) receives value c of fit i.
template <class Value, class Visit>
void fit_each(const LeastSquares& fit, const BeamNodes& nodes, int count, Value&& value,
              Visit&& visit) {
  std::vector<double> right(std::size_t(nodes.beams) * kLanes), x;
  for (int first = 0; first < count; first += kLanes) {
    const int lanes = std::min(kLanes, count - first);
    for (int j = 0; j < nodes.beams; ++j) {
      for (int r = 0; r < lanes; ++r) right[std::size_t(j) * kLanes + r] = value(first + r, j);
    }
    x.assign(std::size_t(nodes.nodes) * kLanes, 0.0);
    solve_lanes(nodes, fit.factor().data(), right.data(), x.data());
    for (int c = 0; c < nodes.nodes; ++c) {
      for (int r = 0; r < lanes; ++r) visit(first + r, c, x[std::size_t(c) * kLanes + r]);
    }
  }
}

// Sets K = P+ W P+^T, made exactly symmetric about both diagonals.
void fit_matrix(BeamNodes& nodes, const std::vector<double>& weight, double tolerance) {
  const std::vector<double> importance(nodes.beams, 1.0);
  const LeastSquares fit(nodes, tolerance, importance);
  const int n = nodes.nodes, beams = nodes.beams;
  std::vector<double> half(std::size_t(n) * beams);
  fit_each(
      fit, nodes, beams, [&](int i, int j) { return weight[std::abs(j - i)]; },
      [&](int i, int c, double x) { half[std::size_t(c) * beams + i] = x; });
  std::vector<double> k(std::size_t(n) * n);
  fit_each(
      fit, nodes, n, [&](int c, int j) { return half[std::size_t(c) * beams + j]; },
      [&](int c, int d, double x) { k[std::size_t(c) * n + d] = x; });
  nodes.matrix.resize(k.size());
  const auto at = [&](int c, int d) { return k[std::size_t(c) * n + d]; };
  for (int c = 0; c < n; ++c) {
    for (int d = 0; d < n; ++d) {
      const int e = n - 1 - c, f = n - 1 - d;
      nodes.matrix[std::size_t(c) * n + d] = (at(c, d) + at(d, c) + at(e, f) + at(f, e)) / 4;
    }
  }
}

BeamNodes own_nodes(const std::vector<double>& weight) {
  BeamNodes nodes = one_node_a_beam(static_cast<int>(weight.size()));
  for (int c = 0; c < nodes.nodes; ++c) {
    for (int d = 0; d < nodes.nodes; ++d) {
      const int distance = std::abs(c - d);
      nodes.matrix.push_back(distance < nodes.beams ? weight[distance] : 0.0);
    }
  }
  return nodes;
}

double cost_of(int beams, int nodes, int width, double row_cost) {
  return row_cost * nodes + 0.5 * nodes * nodes + 1.0 * beams * width;
}

// The relative L2 error that results when all products of K x are rounded to single precision, as
// the worst of some columns of W.
double rounding_of(const BeamNodes& nodes, const std::vector<double>& weight) {
  std::vector<double> seen(nodes.nodes);  // sums of squares of P's columns
  for (int j = 0; j < nodes.beams; ++j) {
    for (int a = 0; a < nodes.width; ++a) {
      const double w = nodes.weight[std::size_t(j) * nodes.width + a];
      seen[nodes.first[j] + a] += w * w;
    }
  }
  double worst = 0;
  for (const int column : {0, nodes.beams / 3, nodes.beams / 2}) {
    double noise = 0, norm = 0;
    for (int a = 0; a < nodes.width; ++a) {
      const int d = nodes.first[column] + a;
      const double x = nodes.weight[std::size_t(column) * nodes.width + a];
      for (int c = 0; c < nodes.nodes; ++c) {
        noise += seen[c] * std::pow(nodes.matrix[std::size_t(d) * nodes.nodes + c] * x, 2);
      }
    }
    for (int j = 0; j < nodes.beams; ++j) norm += std::pow(weight[std::abs(j - column)], 2);
    worst = std::max(worst, std::sqrt(noise / norm));
  }
  return kNodeRounding * worst;
}

// The fewest nodes, in steps of 4, of a width that hold the tolerance and cost less than `bound`.
// nodes = 0 if there are none. Rounding errors rise with the width: where they leave none, `widest`
// becomes a lower width.
BeamNodes fewest_nodes(const std::vector<double>& weight, double tolerance, int width,
                       double row_cost, double bound, int& widest) {
  const int beams = static_cast<int>(weight.size());
  const auto too_many = [&](int quarter) {
    return quarter >= beams / 4 || cost_of(beams, 4 * quarter, width, row_cost) >= bound;
  };
  const std::vector<double> places = equal_places(beams);
  int low = (width + 5) / 4, high = beams / 4;
  while (low < high && !too_many(low)) {
    const int middle = (low + high) / 2;
    const bool good =
        error_of(make_nodes(places, 4 * middle, width), weight, tolerance) <= tolerance;
    (good ? high : low) = good ? middle : middle + 1;
  }
  if (too_many(low)) return {};
  for (; !too_many(low); ++low) {
    BeamNodes nodes = make_nodes(places, 4 * low, width);
    fit_matrix(nodes, weight, tolerance);
    if (rounding_of(nodes, weight) > tolerance) continue;
    nodes.error = error_of(nodes, weight, tolerance);
    return nodes;
  }
  widest = width - 1;
  return {};
}

}  // namespace

BeamNodes choose_beam_nodes(const std::vector<double>& weight, double tolerance, double row_cost) {
  const int beams = static_cast<int>(weight.size());
  BeamNodes best;
  double least = cost_of(beams, beams + beams % 2, 1, row_cost);
  int widest = *std::ranges::max_element(kNodeWidths);
  for (const int width : kNodeWidths) {
    if (width > widest) continue;
    BeamNodes nodes = fewest_nodes(weight, tolerance, width, row_cost, least, widest);
    if (nodes.nodes == 0) continue;
    least = cost_of(beams, nodes.nodes, width, row_cost);
    best = std::move(nodes);
  }
  return best.nodes == 0 ? own_nodes(weight) : best;
}

}  // namespace ensonify
