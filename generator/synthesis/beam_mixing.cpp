#include "synthesis/beam_mixing.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/sonar.h"
#include "synthesis/cpu/gridding.h"

namespace ensonify {
namespace {

// Columns gathered at once, so that each row is read in whole cache lines.
constexpr int kColumnBlock = 8;

constexpr double kNodeRounding = 1e-7;
constexpr double kRidge = 0.01;

// Solves (P^T P + ridge) x = P^T b. The matrix is a band as wide as the nodes that a beam reaches.
class LeastSquares {
 public:
  LeastSquares(const BeamNodes& nodes, double tolerance) : p_(nodes), band_(nodes.width) {
    factor_.assign(std::size_t(p_.nodes) * band_, 0.0);
    for (int j = 0; j < p_.beams; ++j) {
      const double* w = p_.weight.data() + std::size_t(j) * p_.width;
      for (int a = 0; a < p_.width; ++a) {
        for (int b = 0; b <= a; ++b) at(p_.first[j] + a, p_.first[j] + b) += w[a] * w[b];
      }
    }
    double largest = 0;
    for (int i = 0; i < p_.nodes; ++i) largest = std::max(largest, at(i, i));
    // Without the ridge, large values that cancel would fit better than necessary, but increase the
    // rounding errors.
    const double ridge = largest * std::max(1e-14, kRidge * tolerance * tolerance);
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
      const double v = value(j);
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

 private:
  double& at(int i, int k) { return factor_[std::size_t(i) * band_ + (i - k)]; }
  double at(int i, int k) const { return factor_[std::size_t(i) * band_ + (i - k)]; }

  const BeamNodes& p_;
  int band_;
  std::vector<double> factor_;
};

// Equally spaced nodes. They extend past the fan's ends by no more than the beams at the ends need.
BeamNodes make_nodes(int beams, int count, int width) {
  BeamNodes nodes;
  nodes.beams = beams;
  nodes.nodes = count;
  nodes.width = width;
  const double spacing = (beams - 1.0) / (count - width);
  const double beta = 2.3 * width * 0.85;
  for (int j = 0; j < beams; ++j) {
    const double at = (j - (beams - 1) / 2.0) / spacing + (count - 1) / 2.0;
    const int first = std::clamp(static_cast<int>(std::ceil(at - width / 2.0)), 0, count - width);
    nodes.first.push_back(first);
    for (int a = 0; a < width; ++a) {
      const double z = (first + a - at) / (width / 2.0);
      nodes.weight.push_back(window(beta, z));
    }
  }
  return nodes;
}

double error_of(const BeamNodes& nodes, const std::vector<double>& weight, double tolerance) {
  const LeastSquares fit(nodes, tolerance);
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
  const LeastSquares fit(nodes, tolerance);
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

BeamNodes one_node_a_beam(const std::vector<double>& weight) {
  BeamNodes nodes;
  nodes.beams = static_cast<int>(weight.size());
  nodes.nodes = nodes.beams + nodes.beams % 2;
  nodes.width = 1;
  nodes.weight.assign(nodes.beams, 1.0);
  for (int j = 0; j < nodes.beams; ++j) nodes.first.push_back(j);
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
  int low = (width + 5) / 4, high = beams / 4;
  while (low < high && !too_many(low)) {
    const int middle = (low + high) / 2;
    const bool good =
        error_of(make_nodes(beams, 4 * middle, width), weight, tolerance) <= tolerance;
    (good ? high : low) = good ? middle : middle + 1;
  }
  for (; !too_many(low); ++low) {
    BeamNodes nodes = make_nodes(beams, 4 * low, width);
    fit_matrix(nodes, weight, tolerance);
    if (rounding_of(nodes, weight) > tolerance) continue;
    nodes.error = error_of(nodes, weight, tolerance);
    return nodes;
  }
  return {};
}

}  // namespace

BeamMixer::BeamMixer(const Mixing& mixing)
    : beams_(mixing.beams()),
      scale_(mixing.scale),
      // Twice the fan, so that the circular convolution does not join its two ends.
      forward_(smooth_even_length(2 * beams_), FftDirection::forward),
      backward_(smooth_even_length(2 * beams_), FftDirection::backward) {
  amplitude_matrix_.reserve(mixing.matrix.size());
  power_matrix_.reserve(mixing.matrix.size());
  for (std::size_t at = 0; at < mixing.matrix.size(); ++at) {
    amplitude_matrix_.push_back(scale_[at / scale_.size()] * mixing.matrix[at]);
    power_matrix_.push_back(amplitude_matrix_.back() * amplitude_matrix_.back());
  }
  if (!mixing.is_equal()) return;
  std::vector<double> squared(beams_);
  for (int k = 0; k < beams_; ++k) squared[k] = mixing.weight[k] * mixing.weight[k];
  for (const double s : scale_) power_scale_.push_back(s * s);
  amplitude_spectrum_ = kernel_spectrum(mixing.weight);
  power_spectrum_ = kernel_spectrum(squared);
}

std::vector<double> BeamMixer::kernel_spectrum(const std::vector<double>& weight) const {
  const int length = forward_.length();
  AlignedBuffer<std::complex<double>> kernel(length);
  kernel[0] = weight[0];
  for (int k = 1; k < beams_; ++k) kernel[k] = kernel[length - k] = weight[k];
  forward_.run(kernel.data());
  std::vector<double> spectrum(length);
  for (int k = 0; k < length; ++k) spectrum[k] = kernel[k].real() / length;
  return spectrum;
}

void BeamMixer::convolve(std::complex<double>* column, const std::vector<double>& spectrum) const {
  forward_.run(column);
  for (int k = 0; k < forward_.length(); ++k) column[k] *= spectrum[k];
  backward_.run(column);
}

template <class Value>
void BeamMixer::mix_by_matrix(Value* rows, int columns, int stride,
                              const std::vector<double>& matrix, const Workers& workers) const {
  workers.for_each((columns + kColumnBlock - 1) / kColumnBlock, [&](std::size_t block) {
    const int first = static_cast<int>(block) * kColumnBlock;
    const int count = std::min(kColumnBlock, columns - first);
    std::vector<Value> cells(std::size_t(beams_) * kColumnBlock);
    for (int i = 0; i < beams_; ++i) {
      std::copy_n(rows + std::size_t(i) * stride + first, count,
                  cells.data() + std::size_t(i) * kColumnBlock);
    }
    for (int j = 0; j < beams_; ++j) {
      const double* weight = matrix.data() + std::size_t(j) * beams_;
      Value sum[kColumnBlock] = {};
      for (int i = 0; i < beams_; ++i) {
        const Value* cell = cells.data() + std::size_t(i) * kColumnBlock;
        for (int c = 0; c < kColumnBlock; ++c) sum[c] += weight[i] * cell[c];
      }
      std::copy_n(sum, count, rows + std::size_t(j) * stride + first);
    }
  });
}

void BeamMixer::mix_amplitude(std::complex<double>* rows, int columns, int stride,
                              const Workers& workers) const {
  if (!amplitude_matrix_.empty()) {
    return mix_by_matrix(rows, columns, stride, amplitude_matrix_, workers);
  }
  const int length = forward_.length();
  const int pitch = (length + 3) / 4 * 4;  // keeps every column on a 64-byte boundary
  workers.for_each((columns + kColumnBlock - 1) / kColumnBlock, [&](std::size_t block) {
    const int first = static_cast<int>(block) * kColumnBlock;
    const int count = std::min(kColumnBlock, columns - first);
    AlignedBuffer<std::complex<double>> scratch(std::size_t(pitch) * count);
    for (int j = 0; j < beams_; ++j) {
      const std::complex<double>* row = rows + std::size_t(j) * stride + first;
      for (int c = 0; c < count; ++c) scratch[std::size_t(c) * pitch + j] = row[c];
    }
    for (int c = 0; c < count; ++c) {
      convolve(scratch.data() + std::size_t(c) * pitch, amplitude_spectrum_);
    }
    for (int j = 0; j < beams_; ++j) {
      std::complex<double>* row = rows + std::size_t(j) * stride + first;
      for (int c = 0; c < count; ++c) row[c] = scale_[j] * scratch[std::size_t(c) * pitch + j];
    }
  });
}

void BeamMixer::mix_power(double* rows, int columns, int stride, const Workers& workers) const {
  if (!power_matrix_.empty()) return mix_by_matrix(rows, columns, stride, power_matrix_, workers);
  const int length = forward_.length();
  const int pitch = (length + 3) / 4 * 4;
  // Two real columns share one complex transform, because the kernel's spectrum is real.
  constexpr int kPairs = kColumnBlock / 2;
  workers.for_each((columns + kColumnBlock - 1) / kColumnBlock, [&](std::size_t block) {
    const int first = static_cast<int>(block) * kColumnBlock;
    const int count = std::min(kColumnBlock, columns - first);
    AlignedBuffer<std::complex<double>> scratch(std::size_t(pitch) * kPairs);
    for (int j = 0; j < beams_; ++j) {
      const double* row = rows + std::size_t(j) * stride + first;
      for (int c = 0; c < count; c += 2) {
        scratch[std::size_t(c / 2) * pitch + j] = {row[c], c + 1 < count ? row[c + 1] : 0.0};
      }
    }
    for (int p = 0; p < (count + 1) / 2; ++p) {
      convolve(scratch.data() + std::size_t(p) * pitch, power_spectrum_);
    }
    for (int j = 0; j < beams_; ++j) {
      double* row = rows + std::size_t(j) * stride + first;
      for (int c = 0; c < count; ++c) {
        const std::complex<double> pair = scratch[std::size_t(c / 2) * pitch + j];
        row[c] = power_scale_[j] * (c % 2 == 0 ? pair.real() : pair.imag());
      }
    }
  });
}

BeamNodes choose_beam_nodes(const std::vector<double>& weight, double tolerance, double row_cost) {
  const int beams = static_cast<int>(weight.size());
  BeamNodes best;
  double least = cost_of(beams, beams + beams % 2, 1, row_cost);
  // Likely widths come first, so that widths that cost more are not tried.
  for (const int width : {9, 10, 8, 11, 7, 12, 6, 14, 5, 4}) {
    BeamNodes nodes = fewest_nodes(weight, tolerance, width, row_cost, least);
    if (nodes.nodes == 0) continue;
    least = cost_of(beams, nodes.nodes, width, row_cost);
    best = std::move(nodes);
  }
  return best.nodes == 0 ? one_node_a_beam(weight) : best;
}

}  // namespace ensonify
