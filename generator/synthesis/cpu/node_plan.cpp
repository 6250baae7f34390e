#include <algorithm>
#include <cmath>

#include "core/sonar.h"
#include "synthesis/cpu/node_sums.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// Transforming a sample of one plane costs about as much as this many products of the mixing.
constexpr double kRowCost = 325;
// What kernel and nodes may take of the tolerance; they add by squares. The kernel is mostly held
// tighter, for the sake of tails.
constexpr double kKernelShare = 0.4, kNodeShare = 0.3;
// Expected power is shown in decibels, where side lobes far under a strong echo are still seen.
constexpr double kPowerTolerance = 3e-6;

// A band that ends with a step leaves no tail of an echo that lies on a sample, but one of what
// single precision rounds off.
bool has_sharp_edges(const std::vector<Complex>& spectrum) {
  double largest = 0;
  for (const Complex& s : spectrum) largest = std::max(largest, std::abs(s));
  return std::max(std::abs(spectrum.front()), std::abs(spectrum.back())) > 0.1 * largest;
}

// matrix [n/2][n/2] -> [blocks of kRowBlock rows][n/2][kRowBlock].
std::vector<float> packed(const BeamNodes& nodes, double sign) {
  const int n = nodes.nodes, half = n / 2;
  const int blocks = (half + kRowBlock - 1) / kRowBlock;
  std::vector<float> result(std::size_t(blocks) * kRowBlock * half);
  for (int c = 0; c < half; ++c) {
    for (int d = 0; d < half; ++d) {
      const double* row = nodes.matrix.data() + std::size_t(c) * n;
      const std::size_t block = std::size_t(c / kRowBlock) * half + d;
      result[block * kRowBlock + c % kRowBlock] =
          static_cast<float>((row[d] + sign * row[n - 1 - d]) / 2);
    }
  }
  return result;
}

std::unique_ptr<NodePlan> make_plan(const SynthesisSetup& setup, SpreadKernel spread,
                                    BeamNodes nodes, const std::vector<double>& scale,
                                    int segments) {
  const int bins = setup.record.transform;
  auto plan = std::make_unique<NodePlan>(
      NodePlan{.nodes = {},
               .spread = {},
               .samples = setup.record.samples,
               .transform = bins,
               .rows = nodes.nodes * segments / 2,
               .segments = segments,
               .weight = {},
               .out_weight = {},
               .even = packed(nodes, 1),
               .odd = packed(nodes, -1),
               .filter = AlignedBuffer<Complex>(bins),
               .upper_filter = AlignedBuffer<Complex>(bins),
               .cell_filter = AlignedBuffer<Complex>(bins),
               .row_filter = {},
               .grid_forward = ComplexFft(spread.points, FftDirection::forward),
               .cell_forward = ComplexFft(bins, FftDirection::forward),
               .backward = ComplexFft(bins, FftDirection::backward)});
  for (int j = 0; j < nodes.beams; ++j) {
    for (int a = 0; a < nodes.width; ++a) {
      const double w = nodes.weight[std::size_t(j) * nodes.width + a];
      plan->weight.push_back(static_cast<float>(w));
      plan->out_weight.push_back(static_cast<float>(w * scale[j]));
    }
  }
  plan->nodes = std::move(nodes);
  plan->spread = std::move(spread);
  return plan;
}

}  // namespace

std::unique_ptr<NodePlan> make_series_plan(const SynthesisSetup& setup, const Mixing& mixing,
                                           const std::vector<Complex>& spectrum, double tolerance) {
  const int bins = setup.record.transform, half = bins / 2;
  if (has_sharp_edges(spectrum)) return nullptr;
  SpreadKernel spread = choose_spread_kernel(spectrum, -half, kKernelShare * tolerance);
  if (spread.points == 0) return nullptr;
  auto plan = make_plan(setup, std::move(spread),
                        choose_beam_nodes(mixing.weight, kNodeShare * tolerance, 2 * kRowCost),
                        mixing.scale, 2);
  for (int k = -half; k < half; ++k) {
    const int bin = k < 0 ? k + bins : k;
    auto& filter = k < 0 ? plan->upper_filter : plan->filter;
    filter[bin] = spectrum[k + half] * plan->spread.correction[std::abs(k)];
    plan->cell_filter[bin] = spectrum[k + half];
  }
  return plan;
}

std::unique_ptr<NodePlan> make_power_plan(const SynthesisSetup& setup, const Mixing& mixing,
                                          const std::vector<Complex>& autospectrum) {
  const int bins = setup.record.transform;
  std::vector<double> squared, scale;
  std::vector<Complex> both_sides(2 * bins - 1);
  for (int k = 0; k < bins; ++k) {
    both_sides[bins - 1 + k] = autospectrum[k];
    both_sides[bins - 1 - k] = std::conj(autospectrum[k]);
  }
  for (const double w : mixing.weight) squared.push_back(w * w);
  for (const double s : mixing.scale) scale.push_back(s * s);
  SpreadKernel spread = choose_spread_kernel(both_sides, 1 - bins, kKernelShare * kPowerTolerance);
  if (spread.points == 0) return nullptr;
  auto plan =
      make_plan(setup, std::move(spread),
                choose_beam_nodes(squared, kNodeShare * kPowerTolerance, 2 * kRowCost), scale, 1);
  // |s|^2 fills twice the band of s; sampled at 1/b its upper half folds onto the lower one.
  for (int k = 0; k < bins; ++k) {
    plan->filter[k] = autospectrum[k] * plan->spread.correction[k];
    plan->cell_filter[k] = autospectrum[k];
    if (k == 0) continue;
    const Complex folded = std::conj(autospectrum[bins - k]);
    plan->upper_filter[k] = folded * plan->spread.correction[bins - k];
    plan->cell_filter[k] += folded;
  }
  return plan;
}

}  // namespace ensonify
