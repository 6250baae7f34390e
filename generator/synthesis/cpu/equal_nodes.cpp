#include "synthesis/cpu/beam_nodes.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

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

// Sets K = P+ W P+^T, made exactly symmetric about both diagonals.
void fit_matrix(BeamNodes& nodes, const std::vector<double>& weight, double tolerance) {
  const std::vector<double> importance(nodes.beams, 1.0);
  const LeastSquares fit(nodes, tolerance, importance);
  const int n = nodes.nodes, beams = nodes.beams;
  std::vector<double> half(std::size_t(n) * beams);
  for (int i = 0; i < beams; ++i) {
    const std::vector<double> x = fit.solve([&](int j) { return weight[std::abs(j - i)]; });
    for (int c = 0; c < n; ++c) half[std::size_t(c) * beams + i] = x[c];
  }
  std::vector<double> k(std::size_t(n) * n);
  for (int c = 0; c < n; ++c) {
    const std::vector<double> x =
        fit.solve([&](int j) { return half[std::size_t(c) * beams + j]; });
    std::copy(x.begin(), x.end(), k.begin() + std::ptrdiff_t(c) * n);
  }
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
// nodes = 0 if there are none.
BeamNodes fewest_nodes(const std::vector<double>& weight, double tolerance, int width,
                       double row_cost, double bound) {
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
  for (; !too_many(low); ++low) {
    BeamNodes nodes = make_nodes(places, 4 * low, width);
    fit_matrix(nodes, weight, tolerance);
    if (rounding_of(nodes, weight) > tolerance) continue;
    nodes.error = error_of(nodes, weight, tolerance);
    return nodes;
  }
  return {};
}

}  // namespace

BeamNodes choose_beam_nodes(const std::vector<double>& weight, double tolerance, double row_cost) {
  const int beams = static_cast<int>(weight.size());
  BeamNodes best;
  double least = cost_of(beams, beams + beams % 2, 1, row_cost);
  for (const int width : kNodeWidths) {
    BeamNodes nodes = fewest_nodes(weight, tolerance, width, row_cost, least);
    if (nodes.nodes == 0) continue;
    least = cost_of(beams, nodes.nodes, width, row_cost);
    best = std::move(nodes);
  }
  return best.nodes == 0 ? own_nodes(weight) : best;
}

}  // namespace ensonify
