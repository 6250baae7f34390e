// What the searches for nodes of equal and of unequal beams share.
//
//   kNodeRounding  kNodeWidths
//   LeastSquares     node values that fit given values at the beams
//   make_nodes       equally spaced nodes
//   one_node_a_beam  as many nodes as beams
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "synthesis/cpu/beam_nodes.h"
#include "synthesis/cpu/gridding.h"

namespace ensonify {

// The relative error of a product of node and weight in single precision.
inline constexpr double kNodeRounding = 1e-7;
// The widths to try. Likely ones come first, so that widths that cost more are not tried.
inline constexpr int kNodeWidths[] = {9, 10, 8, 11, 7, 12, 6, 14, 5, 4};

// Solves (P^T I P + ridge) x = P^T I b, with the importance I of each beam. The matrix is a band as
// wide as the nodes that a beam reaches.
class LeastSquares {
 public:
  LeastSquares(const BeamNodes& nodes, double tolerance, const std::vector<double>& importance)
      : p_(nodes), importance_(importance), band_(nodes.width) {
    factor_.assign(std::size_t(p_.nodes) * band_, 0.0);
    for (int j = 0; j < p_.beams; ++j) {
      const double* w = p_.weight.data() + std::size_t(j) * p_.width;
      for (int a = 0; a < p_.width; ++a) {
        const double scaled = importance_[j] * w[a];
        for (int b = 0; b <= a; ++b) at(p_.first[j] + a, p_.first[j] + b) += scaled * w[b];
      }
    }
    double largest = 0;
    for (int i = 0; i < p_.nodes; ++i) largest = std::max(largest, at(i, i));
    // Without the ridge, large values that cancel would fit better than necessary, but increase the
    // rounding errors.
    const double ridge = largest * std::max(1e-14, 0.01 * tolerance * tolerance);
    for (int i = 0; i < p_.nodes; ++i) at(i, i) += ridge;
    for (int i = 0; i < p_.nodes; ++i) {
      const int low = std::max(0, i - band_ + 1);
      for (int k = low; k <= i; ++k) {
        double sum = at(i, k);
        for (int l = low; l < k; ++l) {
          if (k - l < band_) sum -= at(i, l) * at(k, l);
        }
        at(i, k) = k == i ? std::sqrt(sum) : sum / at(k, k);
      }
    }
  }

  // The node values [nodes] that fit value(j) at every beam j.
  template <class Value>
  std::vector<double> solve(Value&& value) const {
    std::vector<double> x(p_.nodes);
    for (int j = 0; j < p_.beams; ++j) {
      const double v = importance_[j] * value(j);
      for (int a = 0; a < p_.width; ++a) {
        x[p_.first[j] + a] += p_.weight[std::size_t(j) * p_.width + a] * v;
      }
    }
    for (int i = 0; i < p_.nodes; ++i) {
      for (int l = std::max(0, i - band_ + 1); l < i; ++l) x[i] -= at(i, l) * x[l];
      x[i] /= at(i, i);
    }
    for (int i = p_.nodes - 1; i >= 0; --i) {
      for (int l = i + 1; l < std::min(p_.nodes, i + band_); ++l) x[i] -= at(l, i) * x[l];
      x[i] /= at(i, i);
    }
    return x;
  }

  // The lower triangle [nodes][band] of the Cholesky factor: row i, column i - k at k.
  std::span<const double> factor() const { return factor_; }

 private:
  double& at(int i, int k) { return factor_[std::size_t(i) * band_ + (i - k)]; }
  double at(int i, int k) const { return factor_[std::size_t(i) * band_ + (i - k)]; }

  const BeamNodes& p_;
  const std::vector<double>& importance_;
  int band_;
  std::vector<double> factor_;
};

// Equally spaced nodes for beams at the given places, which increase. They extend past the fan's
// ends by no more than the beams at the ends need.
inline BeamNodes make_nodes(const std::vector<double>& place, int count, int width) {
  BeamNodes nodes;
  nodes.beams = static_cast<int>(place.size());
  nodes.nodes = count;
  nodes.width = width;
  const double spacing = (place.back() - place.front()) / (count - width);
  const double beta = 2.3 * width * 0.85;
  for (int j = 0; j < nodes.beams; ++j) {
    const double at = place[j] / spacing + (count - 1) / 2.0;
    const int first = std::clamp(static_cast<int>(std::ceil(at - width / 2.0)), 0, count - width);
    nodes.first.push_back(first);
    for (int a = 0; a < width; ++a) {
      const double z = (first + a - at) / (width / 2.0);
      nodes.weight.push_back(window(beta, z));
    }
  }
  return nodes;
}

// Without the matrix.
inline BeamNodes one_node_a_beam(int beams) {
  BeamNodes nodes;
  nodes.beams = beams;
  nodes.nodes = beams + beams % 2;
  nodes.width = 1;
  nodes.weight.assign(beams, 1.0);
  for (int j = 0; j < beams; ++j) nodes.first.push_back(j);
  return nodes;
}

}  // namespace ensonify
