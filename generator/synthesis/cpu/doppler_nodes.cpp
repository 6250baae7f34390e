#include "synthesis/cpu/doppler_nodes.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/units.h"
#include "synthesis/fft.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;
using Spectrum = std::vector<Complex>;

constexpr double kShare = 0.3;         // of the tolerance
constexpr double kTail = 1e-6;         // of the norm; weaker tails have no separate limit
constexpr double kNominalSpan = 1e-3;  // of the Doppler in a ping
constexpr double kMostCost = 1000;     // nodes over this span
constexpr double kWidest = 0.02, kMostNodesPerBin = 8;
constexpr double kStep = 1.2;  // the ratio to which the search for the width goes

// The place of node q in its band, from 0 to 1.
double place_in_band(int q, int degree) { return 0.5 - 0.5 * std::cos(kPi * q / degree); }

double norm_of(const Spectrum& s) {
  double sum = 0;
  for (const Complex& v : s) sum += std::norm(v);
  return std::sqrt(sum);
}

// Measures the error of interpolated pulses.
class Judge {
 public:
  Judge(const DopplerPulse& pulse, double tolerance)
      : pulse_(pulse),
        tolerance_(tolerance),
        norm_(norm_of(doppler_spectrum(pulse, 0))),
        samples_(pulse.transform),
        backward_(pulse.transform, FftDirection::backward) {}

  // Whether the tolerance holds in the bands at three values of Doppler: at rest, where the pulse
  // reaches the edge of the frequency band, and where the edge has cut off a quarter of it.
  bool holds(const DopplerNodes& nodes) {
    const double bandwidths = pulse_.sonar.frequency_hz / pulse_.sonar.bandwidth_hz;
    for (const double shift : {0.0, 0.12, 0.25}) {
      const int first = static_cast<int>(shift / (bandwidths * nodes.width)) * nodes.degree;
      if (!holds(nodes, first, 1) || !holds(nodes, -first, -1)) return false;
    }
    return true;
  }

 private:
  // The same for one band, halfway between nodes, in its middle and at its ends.
  bool holds(const DopplerNodes& nodes, int first, int step) {
    std::vector<Spectrum> at_node;
    std::vector<double> doppler;
    for (int q = 0; q <= nodes.degree; ++q) {
      const double u = place_in_band(q, nodes.degree);
      doppler.push_back(step * (std::abs(first) / nodes.degree + u) * nodes.width);
      at_node.push_back(doppler_spectrum(pulse_, doppler.back()));
    }
    for (const int q : {0, nodes.degree / 2, nodes.degree - 1}) {
      const double between = (doppler[q] + doppler[q + 1]) / 2;
      const DopplerWeights weights = weights_at(nodes, between);
      const Spectrum exact = doppler_spectrum(pulse_, between);
      Spectrum error = exact;
      for (int k = 0; k <= nodes.degree; ++k) {
        for (std::size_t m = 0; m < error.size(); ++m) error[m] -= weights.value[k] * at_node[k][m];
      }
      if (norm_of(error) > kShare * tolerance_ * norm_ || !tails_hold(error, exact)) return false;
    }
    return true;
  }

  bool tails_hold(const Spectrum& error, const Spectrum& exact) {
    const std::vector<double> wrong = tails_of(error), right = tails_of(exact);
    for (std::size_t i = 0; i < wrong.size(); ++i) {
      const double scale = std::max(right[i], kTail * kTail * right[0]);
      if (wrong[i] > 100 * tolerance_ * tolerance_ * scale) return false;
    }
    return true;
  }

  // The energy of the samples at a distance of at least x from the middle, for x = 0, 1, 2, 4, ...
  std::vector<double> tails_of(const Spectrum& spectrum) {
    const int count = static_cast<int>(spectrum.size());
    std::copy(spectrum.begin(), spectrum.end(), samples_.begin());
    backward_.run(samples_.data());
    std::vector<double> tails;
    for (int x = 0; x < count / 2; x = x == 0 ? 1 : 2 * x) {
      double sum = 0;
      for (int n = x; n <= count - x && n < count; ++n) sum += std::norm(samples_[n]);
      tails.push_back(sum);
    }
    return tails;
  }

  const DopplerPulse& pulse_;
  double tolerance_, norm_;
  AlignedBuffer<Complex> samples_;
  ComplexFft backward_;
};

}  // namespace

DopplerNodes choose_doppler_nodes(const DopplerPulse& pulse, double tolerance) {
  Judge judge(pulse, tolerance);
  const double bin = pulse.sonar.bandwidth_hz / (pulse.sonar.frequency_hz * pulse.transform);
  DopplerNodes best;
  double least = kMostCost, width = 0;
  for (const int degree : {2, 3, 4, 6, 8, 11, 16, DopplerNodes::kMostDegree}) {
    // A higher degree holds for all widths for which a lower degree does.
    double low = std::max(width, bin * degree / kMostNodesPerBin), high = kWidest;
    if (low * kStep >= high || !judge.holds({degree, low})) continue;
    while (high > kStep * low) {
      const double middle = std::sqrt(low * high);
      (judge.holds({degree, middle}) ? low : high) = middle;
    }
    width = low;
    // The expected number of nodes, because the span may begin anywhere within a band.
    const double cost = degree * (kNominalSpan / width + 1) + 1;
    if (cost > 1.5 * least) break;
    if (cost >= least) continue;
    least = cost;
    best = {degree, width};
  }
  return best;
}

double node_doppler(const DopplerNodes& nodes, int node) {
  const int n = std::abs(node);
  const double doppler =
      (n / nodes.degree + place_in_band(n % nodes.degree, nodes.degree)) * nodes.width;
  return node < 0 ? -doppler : doppler;
}

DopplerWeights weights_at(const DopplerNodes& nodes, double doppler) {
  DopplerWeights weights;
  const auto [first_node, step] = DopplerWeigher(nodes).weigh(doppler, weights.value.data());
  weights.first_node = first_node;
  weights.step = step;
  return weights;
}

DopplerWeigher::DopplerWeigher(const DopplerNodes& nodes)
    : degree_(nodes.degree), width_(nodes.width) {
  for (int q = 0; q <= degree_; ++q) place_[q] = place_in_band(q, degree_);
  for (int q = 0; q <= degree_; ++q) {
    scale_[q] = 1;
    for (int r = 0; r <= degree_; ++r) {
      if (r != q) scale_[q] /= place_[q] - place_[r];
    }
  }
}

DopplerWeigher::Band DopplerWeigher::weigh(double doppler, double* value) const {
  const int step = doppler < 0 ? -1 : 1;
  const double at = std::abs(doppler) / width_;
  const int band = static_cast<int>(at);
  const double u = at - band;
  // L_q is the product of (u - place) over the other nodes: those below q, then those above.
  double product = 1;
  for (int q = 0; q <= degree_; ++q) {
    value[q] = scale_[q] * product;
    product *= u - place_[q];
  }
  product = 1;
  for (int q = degree_; q >= 0; --q) {
    value[q] *= product;
    product *= u - place_[q];
  }
  return {step * band * degree_, step};
}

double largest_magnitude(const std::vector<std::complex<double>>& spectrum) {
  double most = 0;
  for (const Complex& s : spectrum) most = std::max(most, std::abs(s));
  return most;
}

NodeSpectra::NodeSpectra(DopplerPulse pulse, DopplerNodes nodes)
    : pulse_(std::move(pulse)),
      nodes_(nodes),
      loudest_(largest_magnitude(doppler_spectrum(pulse_, 0))) {}

Spectrum NodeSpectra::at(int node) const {
  Spectrum spectrum = doppler_spectrum(pulse_, node_doppler(nodes_, node));
  if (largest_magnitude(spectrum) <= kInaudible * loudest_) spectrum.clear();
  return spectrum;
}

}  // namespace ensonify
