#include <algorithm>
#include <cmath>

#include "synthesis/cpu/beam_fit.h"
#include "synthesis/cpu/beam_nodes.h"

namespace ensonify {
namespace {

// Unequal beams. Each beam has its own row of R: the fit of its weights over all cells, in which
// every cell counts by its column's norm, so that the errors of all columns are alike relative to
// their norms.
class UnequalFit {
 public:
  UnequalFit(const std::vector<double>& matrix, const std::vector<double>& middle_rad,
             double tolerance, double row_cost)
      : matrix_(matrix),
        beams_(static_cast<int>(middle_rad.size())),
        tolerance_(tolerance),
        row_cost_(row_cost),
        energy_(beams_),
        importance_(beams_) {
    const double middle = (middle_rad.front() + middle_rad.back()) / 2;
    for (const double azimuth : middle_rad) places_.push_back(azimuth - middle);
    for (std::size_t at = 0; at < matrix.size(); ++at) {
      energy_[at % energy_.size()] += matrix[at] * matrix[at];
    }
    const double most = *std::max_element(energy_.begin(), energy_.end());
    for (int i = 0; i < beams_; ++i) {
      importance_[i] = most > 0 ? 1 / std::max(energy_[i] / most, kFaintest) : 1;
    }
    constexpr int kFirstTrials = 8;
    for (int k = 0; k < kFirstTrials; ++k) trials_.push_back(k * (beams_ - 1) / (kFirstTrials - 1));
  }

  double cost(int nodes, int width) const {
    return (row_cost_ + beams_) * nodes + 1.0 * beams_ * width;
  }

  // As fewest_nodes of equal beams.
  BeamNodes fewest_nodes(int width, double bound) {
    int low = (width + 5) / 4, end = low;
    while (4 * end < beams_ && cost(4 * end, width) < bound) ++end;
    while (low < end) {
      for (int high = end; low < high;) {
        const int middle = (low + high) / 2;
        if (trials_hold(make_nodes(places_, 4 * middle, width))) {
          high = middle;
        } else {
          low = middle + 1;
        }
      }
      if (low == end) break;
      BeamNodes nodes = make_nodes(places_, 4 * low, width);
      const int hardest = fit(nodes);
      if (nodes.error <= tolerance_) return nodes;
      trials_.push_back(hardest);
      ++low;
    }
    return {};
  }

 private:
  // Weaker columns, in energy relative to the strongest, do not count more than this in the fit.
  static constexpr double kFaintest = 1e-8;

  std::vector<double> row_of(const LeastSquares& squares, int beam) const {
    const double* weight = matrix_.data() + std::size_t(beam) * beams_;
    return squares.solve([&](int cell) { return weight[cell]; });
  }

  // Calls visit(cell, error) for all cells of a beam.
  template <class Visit>
  void for_each_error(const BeamNodes& nodes, const std::vector<double>& row, int beam,
                      Visit&& visit) const {
    for (int i = 0; i < beams_; ++i) {
      double sum = -matrix_[std::size_t(beam) * beams_ + i];
      const double* weight = nodes.weight.data() + std::size_t(i) * nodes.width;
      for (int a = 0; a < nodes.width; ++a) sum += weight[a] * row[nodes.first[i] + a];
      visit(i, sum);
    }
  }

  // Whether a few beams hold the tolerance, on average over the columns.
  bool trials_hold(const BeamNodes& nodes) const {
    const LeastSquares squares(nodes, tolerance_, importance_);
    for (const int beam : trials_) {
      double error = 0, norm = 0;
      for_each_error(nodes, row_of(squares, beam), beam, [&](int cell, double e) {
        error += importance_[cell] * e * e;
        norm += importance_[cell] * std::pow(matrix_[std::size_t(beam) * beams_ + cell], 2);
      });
      if (error > tolerance_ * tolerance_ * norm) return false;
    }
    return true;
  }

  // Sets matrix and error, with that of products in single precision. Returns the beam with the
  // largest part of the errors.
  int fit(BeamNodes& nodes) const {
    const LeastSquares squares(nodes, tolerance_, importance_);
    std::vector<double> wrong(beams_);      // sums of squares over each column of W
    std::vector<double> seen(nodes.nodes);  // ... over each column of R
    double largest = 0;
    int hardest = 0;
    for (int j = 0; j < beams_; ++j) {
      const std::vector<double> row = row_of(squares, j);
      for (int n = 0; n < nodes.nodes; ++n) seen[n] += row[n] * row[n];
      double own = 0;
      for_each_error(nodes, row, j, [&](int cell, double e) {
        wrong[cell] += e * e;
        own += importance_[cell] * e * e;
      });
      if (own > largest) {
        largest = own;
        hardest = j;
      }
      nodes.matrix.insert(nodes.matrix.end(), row.begin(), row.end());
    }
    double worst = 0;
    for (int i = 0; i < beams_; ++i) {
      double noise = 0;
      for (int a = 0; a < nodes.width; ++a) {
        noise +=
            std::pow(nodes.weight[std::size_t(i) * nodes.width + a], 2) * seen[nodes.first[i] + a];
      }
      const double error = std::max(wrong[i], kNodeRounding * kNodeRounding * noise);
      if (error > 0) worst = std::max(worst, error / energy_[i]);
    }
    nodes.error = std::sqrt(worst);
    nodes.is_equal = false;
    return hardest;
  }

  const std::vector<double>& matrix_;
  int beams_;
  double tolerance_, row_cost_;
  std::vector<double> places_;
  std::vector<double> energy_, importance_;  // of each cell's column
  std::vector<int> trials_;                  // beams
};

}  // namespace

BeamNodes choose_unequal_nodes(const std::vector<double>& matrix,
                               const std::vector<double>& middle_rad, double tolerance,
                               double row_cost) {
  const int beams = static_cast<int>(middle_rad.size());
  UnequalFit fit(matrix, middle_rad, tolerance, row_cost);
  BeamNodes best;
  double least = fit.cost(beams + beams % 2, 1);
  for (const int width : kNodeWidths) {
    BeamNodes nodes = fit.fewest_nodes(width, least);
    if (nodes.nodes == 0) continue;
    least = fit.cost(nodes.nodes, width);
    best = std::move(nodes);
  }
  if (best.nodes != 0) return best;
  best = one_node_a_beam(beams);
  best.is_equal = false;
  best.matrix.assign(std::size_t(beams) * best.nodes, 0.0);
  for (int j = 0; j < beams; ++j) {
    std::copy_n(matrix.data() + std::size_t(j) * beams, beams,
                best.matrix.data() + std::size_t(j) * best.nodes);
  }
  return best;
}

}  // namespace ensonify
