#include "synthesis/cpu/spread_kernel.h"

#include <algorithm>
#include <cmath>

#include "core/sonar.h"
#include "core/units.h"
#include "synthesis/cpu/gridding.h"
#include "synthesis/fft.h"

namespace ensonify {
namespace {

constexpr double kFloatRounding = 6e-8;
// The error of tails relative to that of the whole echo. Tails may have ten times the tolerance,
// and there is no other error in them.
constexpr double kTailShare = 12;

// The share of the kernel's tolerance for its polynomials.
constexpr double kFitShare = 0.1;
constexpr int kMostWideTerms = 8;  // the largest number for which kernels are compiled
constexpr int kJudgeNodes = 48;

using Complex = std::complex<double>;

// The pulse of a spectrum, and its energy beyond any distance from the peak. Several fractions of a
// sample are tested as the delay, because the tail depends on it if the band has sharp edges.
class Tails {
 public:
  Tails(const std::vector<Complex>& spectrum, int first)
      : spectrum_(spectrum),
        first_(first),
        lags_((smooth_even_length(static_cast<int>(spectrum.size())) + 1) / 2),
        backward_(2 * lags_ * kPhases, FftDirection::backward),
        pulse_(backward_.length()),
        own_(beyond(magnitudes([](int) { return 1.0; }))) {}

  // The largest ratio of the norm of the error to the norm of the pulse beyond any lag.
  double worst_ratio(const SpreadKernel& kernel) {
    const WindowTransform transform(kernel.width, kernel.beta, kJudgeNodes);
    const int highest = std::max(std::abs(first_), first_ + static_cast<int>(spectrum_.size()) - 1);
    // The spectrum of the grid repeats on both sides of the band. The phase of a copy differs
    // between echoes, so that magnitudes are added.
    constexpr int kSteps = 200;
    std::vector<double> ratio(kSteps + 2);
    for (int i = 0; i <= kSteps; ++i) {
      const double x = static_cast<double>(highest) / kernel.points * (2.0 * i / kSteps - 1.0);
      ratio[i] = transform(1.0 - x) / transform(x);
    }
    const auto ratio_at = [&](int k) {
      const double at = (1.0 + k / static_cast<double>(highest)) * (kSteps / 2);
      const int i = static_cast<int>(at);
      return ratio[i] + (at - i) * (ratio[i + 1] - ratio[i]);
    };
    std::vector<double> error = magnitudes([&](int k) { return ratio_at(-k); });
    const std::vector<double> upper = magnitudes([&](int k) { return ratio_at(k); });
    for (std::size_t i = 0; i < error.size(); ++i) error[i] += upper[i];
    const std::vector<double> wrong = beyond(error);
    double worst = 0;
    for (std::size_t at = 0; at < own_.size(); ++at) {
      if (own_[at] < kJudged * kJudged * own_[at % kPhases]) continue;
      worst = std::max(worst, wrong[at] / own_[at]);
    }
    return std::sqrt(worst);
  }

 private:
  static constexpr double kJudged = 1e-6;
  static constexpr int kPhases = 4;

  // The magnitudes of the pulse of the spectrum times factor(k), at kPhases points per sample. They
  // begin half a step after a sample, because an echo exactly at a sample has no tail if the band
  // has sharp edges.
  template <class Factor>
  std::vector<double> magnitudes(Factor&& factor) {
    const int length = backward_.length();
    std::fill(pulse_.begin(), pulse_.end(), Complex(0));
    for (int i = 0; i < static_cast<int>(spectrum_.size()); ++i) {
      const int k = first_ + i;
      pulse_[(k + length) % length] =
          spectrum_[i] * factor(k) * std::polar(1.0, kPi * k / static_cast<double>(length));
    }
    backward_.run(pulse_.data());
    std::vector<double> magnitude(length);
    for (int i = 0; i < length; ++i) magnitude[i] = std::abs(pulse_[i]);
    return magnitude;
  }

  // [lag][phase]: the energy of samples at a distance of `lag` or more from the peak.
  std::vector<double> beyond(const std::vector<double>& magnitude) const {
    const int length = backward_.length();
    std::vector<double> sum(std::size_t(lags_) * kPhases);
    for (int n = lags_ - 1; n >= 0; --n) {
      for (int phase = 0; phase < kPhases; ++phase) {
        const int at = n * kPhases + phase;
        const double after = magnitude[at];
        const double before = n > 0 ? magnitude[length - n * kPhases + phase] : 0.0;
        sum[at] = after * after + before * before + (n + 1 < lags_ ? sum[at + kPhases] : 0.0);
      }
    }
    return sum;
  }

  const std::vector<Complex>& spectrum_;
  int first_, lags_;
  ComplexFft backward_;
  AlignedBuffer<Complex> pulse_;
  std::vector<double> own_;
};

// The energy in an interval of |k|. The error of the kernel is computed at its upper end, where it
// is largest.
struct Band {
  double k, energy;
};

std::vector<Band> bands_of(const std::vector<double>& energy) {
  constexpr int kBands = 32;
  std::vector<Band> bands;
  const std::size_t count = energy.size();
  for (int i = 0; i < kBands; ++i) {
    const std::size_t first = count * i / kBands, last = count * (i + 1) / kBands;
    if (first == last) continue;
    double sum = 0;
    for (std::size_t k = first; k < last; ++k) sum += energy[k];
    bands.push_back({static_cast<double>(last - 1), sum});
  }
  return bands;
}

// Cosines and sines at the bands, which all windows of one width share: the transforms of all
// shapes are sums of them. They take most of the time of choose_spread_kernel.
class BandWaves {
 public:
  BandWaves(const std::vector<Band>& bands, int points, int width) {
    const std::vector<double> nodes = transform_nodes(width, kJudgeNodes);
    for (const Band& band : bands) add(nodes, band.k / points, at_);
    for (const int grid : {1, 2}) add(nodes, grid, copies_);
  }

  // The window's transform at a band, and the sum of squares of the nearest four copies.
  struct Seen {
    double own = 0, others = 0;
  };
  Seen seen(std::size_t band, const std::vector<double>& weight) const {
    Seen result;
    const Wave* at = at_.data() + band * kJudgeNodes;
    for (int i = 0; i < kJudgeNodes; ++i) result.own += weight[i] * at[i].cosine;
    for (const int copy : {0, 1}) {
      const Wave* shift = copies_.data() + copy * kJudgeNodes;
      double even = 0, odd = 0;
      for (int i = 0; i < kJudgeNodes; ++i) {
        even += weight[i] * at[i].cosine * shift[i].cosine;
        odd += weight[i] * at[i].sine * shift[i].sine;
      }
      result.others += (even - odd) * (even - odd) + (even + odd) * (even + odd);
    }
    return result;
  }

 private:
  struct Wave {
    double cosine, sine;
  };
  static void add(const std::vector<double>& nodes, double x, std::vector<Wave>& waves) {
    for (const double node : nodes) waves.push_back({std::cos(node * x), std::sin(node * x)});
  }

  std::vector<Wave> at_, copies_;  // [band or copy][node]
};

void judge(const std::vector<Band>& bands, const BandWaves& waves, SpreadKernel& kernel) {
  const std::vector<double> weight = transform_weights(kernel.width, kernel.beta, kJudgeNodes);
  double square = 0;
  for (int l = 0; l < kernel.width; ++l) {
    square += std::pow(window(kernel.beta, 2 * (l + 0.5) / kernel.width - 1), 2);
  }
  double alias = 0, noise = 0, total = 0;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const auto [own, others] = waves.seen(i, weight);
    alias += bands[i].energy * others / (own * own);
    noise += bands[i].energy * square / (own * own);
    total += bands[i].energy;
  }
  kernel.alias_error = total > 0 ? std::sqrt(alias / total) : 0;
  kernel.rounding_gain = total > 0 ? std::sqrt(noise / total) : 0;
}

SpreadKernel best_shape(const std::vector<Band>& bands, int points, int width, int highest) {
  SpreadKernel best;
  const BandWaves waves(bands, points, width);
  // The usual beta is pi w (1 - 1/(2 sigma)). Larger values are better if the band's edges have
  // little energy.
  const double usual = kPi * width * (1.0 - static_cast<double>(highest) / points);
  for (const double factor : {0.85, 0.91, 0.97, 1.03, 1.1}) {
    SpreadKernel kernel;
    kernel.points = points;
    kernel.width = width;
    kernel.beta = factor * usual;
    judge(bands, waves, kernel);
    if (best.points == 0 || kernel.alias_error < best.alias_error) best = kernel;
  }
  return best;
}

// Whether FFTW is fast for a smooth length. All short lengths are accepted. Of the long ones, those
// with many factors of 5 and at most one factor of 3 were measured to be fast. Other lengths take
// up to twice the time.
bool is_quick(int length) {
  if (length < 1000) return length % 2 == 0;
  int twos = 0, threes = 0, fives = 0, rest = length;
  for (; rest % 2 == 0; rest /= 2) ++twos;
  for (; rest % 3 == 0; rest /= 3) ++threes;
  for (; rest % 5 == 0; rest /= 5) ++fives;
  return twos >= 3 && fives >= 2 + threes && threes <= 1;
}

// The lengths to try, from the number of bins in the band to three times this number.
std::vector<int> grid_lengths(int highest) {
  std::vector<int> lengths;
  for (int n = 2 * highest + 2; n <= 6 * highest + 64; ++n) {
    n = smooth_even_length(n);
    if (is_quick(n)) lengths.push_back(n);
  }
  return lengths;
}

// The polynomial of one point of the kernel, by interpolation at Chebyshev nodes: coefficients of
// monomials of t / reach, with t in [-reach, reach], constant term first.
std::vector<double> fitted(const SpreadKernel& kernel, int point, int degree, double reach = 1) {
  const int count = degree + 1;
  std::vector<double> chebyshev(count);
  for (int i = 0; i < count; ++i) {
    const double t = reach * std::cos(kPi * (i + 0.5) / count);
    const double z = (2.0 * point + t + 1.0) / kernel.width - 1.0;
    for (int n = 0; n < count; ++n) {
      chebyshev[n] += window(kernel.beta, z) * std::cos(kPi * n * (i + 0.5) / count) *
                      (n == 0 ? 1.0 : 2.0) / count;
    }
  }
  // T_n in monomials, by recurrence.
  std::vector<double> before(count), current(count), sum(count);
  before[0] = 1;
  if (count > 1) current[1] = 1;
  for (int n = 0; n < count; ++n) {
    const std::vector<double>& term = n == 0 ? before : current;
    for (int i = 0; i < count; ++i) sum[i] += chebyshev[n] * term[i];
    if (n == 0) continue;
    std::vector<double> next(count);
    for (int i = 0; i < count; ++i) next[i] = (i > 0 ? 2 * current[i - 1] : 0.0) - before[i];
    before = current;
    current = next;
  }
  return sum;
}

// The largest difference between wide polynomials and the window.
double misfit(const SpreadKernel& kernel, const WidePolynomials& wide, double reach) {
  double worst = 0;
  const int pairs = (kernel.width + 1) / 2;
  for (int l = 0; l < pairs; ++l) {
    const float* c = wide.coefficient.data() + std::size_t(l) * wide.terms * 2;
    for (double x = -1; x <= 1; x += 1.0 / 24) {
      double even = 0, odd = 0;
      for (int i = 0; i < wide.terms; ++i) {
        even = even * x * x + c[2 * i];
        odd = odd * x * x + c[2 * i + 1];
      }
      const double exact = window(kernel.beta, (2.0 * l + reach * x + 1.0) / kernel.width - 1.0);
      worst = std::max(worst, std::abs(even + odd * x - exact));
    }
  }
  return worst;
}

// The largest difference between the kernel's polynomials and the window.
double misfit(const SpreadKernel& kernel) {
  const int floats = kernel.polynomial().chunks * 8;
  double worst = 0;
  for (int l = 0; l < kernel.width; ++l) {
    for (double t = -1; t <= 1; t += 1.0 / 16) {
      double value = 0;
      for (int d = 0; d <= kernel.degree; ++d) {
        value = value * t + kernel.coefficient[std::size_t(d) * floats + 2 * l];
      }
      const double exact = window(kernel.beta, (2.0 * l + t + 1.0) / kernel.width - 1.0);
      worst = std::max(worst, std::abs(value - exact));
    }
  }
  return worst;
}

void fit(SpreadKernel& kernel, int degree) {
  kernel.degree = degree;
  const int floats = kernel.polynomial().chunks * 8;
  kernel.coefficient.assign(std::size_t(degree + 1) * floats, 0.0f);
  for (int l = 0; l < kernel.width; ++l) {
    const std::vector<double> monomial = fitted(kernel, l, degree);
    for (int d = 0; d <= degree; ++d) {
      float* at = kernel.coefficient.data() + std::size_t(degree - d) * floats + 2 * l;
      at[0] = at[1] = static_cast<float>(monomial[d]);
    }
  }
}

void finish(SpreadKernel& kernel, int highest, double tolerance) {
  const WindowTransform transform(kernel.width, kernel.beta, 200);
  kernel.correction.resize(highest + 1);
  for (int k = 0; k <= highest; ++k) {
    kernel.correction[k] = 1.0 / transform(static_cast<double>(k) / kernel.points);
  }
  for (int degree = 4; degree <= kernel.width + 4; ++degree) {
    fit(kernel, degree);
    if (misfit(kernel) * kernel.rounding_gain <= kFitShare * tolerance) return;
  }
}

}  // namespace

SpreadKernel choose_spread_kernel(const std::vector<Complex>& spectrum, int first, double tolerance,
                                  int widest) {
  const int count = static_cast<int>(spectrum.size());
  const int highest = std::max(std::abs(first), first + count - 1);
  std::vector<double> energy(highest + 1);
  for (int i = 0; i < count; ++i) energy[std::abs(first + i)] += std::norm(spectrum[i]);
  Tails tails(spectrum, first);
  const std::vector<Band> bands = bands_of(energy);
  const std::vector<int> lengths = grid_lengths(highest);
  SpreadKernel best;
  double least = 1e300;
  // Likely widths come first, so that kernels that cost more are not tried.
  for (const int width : {8, 12, 10, 14, 11, 9, 7, 6, 5, 4}) {
    if (width > widest) continue;
    // With a hundred echoes per beam, spreading over 4 points costs as much as 1700 points of a
    // transform.
    const double spreading = 1700.0 * ((width + 3) / 4);
    const auto end = std::partition_point(lengths.begin(), lengths.end(),
                                          [&](int points) { return points + spreading < least; });
    // The error decreases with the length of the grid.
    const auto shortest = std::partition_point(lengths.begin(), end, [&](int points) {
      const SpreadKernel kernel = best_shape(bands, points, width, highest);
      return kernel.alias_error > tolerance || kernel.rounding_gain * kFloatRounding > tolerance ||
             tails.worst_ratio(kernel) > kTailShare * tolerance;
    });
    if (shortest == end) continue;
    best = best_shape(bands, *shortest, width, highest);
    least = *shortest + spreading;
  }
  if (best.points != 0) finish(best, highest, tolerance);
  return best;
}

WidePolynomials fit_wide(const SpreadKernel& kernel, double reach, double tolerance) {
  WidePolynomials wide;
  const int pairs = (kernel.width + 1) / 2;
  for (wide.terms = 3; wide.terms <= kMostWideTerms; ++wide.terms) {
    wide.coefficient.assign(std::size_t(pairs) * wide.terms * 2, 0.0f);
    for (int l = 0; l < pairs; ++l) {
      const std::vector<double> monomial = fitted(kernel, l, 2 * wide.terms - 1, reach);
      float* c = wide.coefficient.data() + std::size_t(l) * wide.terms * 2;
      for (int i = 0; i < wide.terms; ++i) {
        c[2 * (wide.terms - 1 - i)] = static_cast<float>(monomial[2 * i]);
        c[2 * (wide.terms - 1 - i) + 1] = static_cast<float>(monomial[2 * i + 1]);
      }
    }
    if (misfit(kernel, wide, reach) * kernel.rounding_gain <= tolerance) return wide;
  }
  --wide.terms;
  return wide;
}

double lost_beyond(const SpreadKernel& kernel, double reach) {
  constexpr int kSteps = 16;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double offset = 2 * (i + 0.5) / kSteps - 1;
      const double beside = (reach - 1) * (2 * (j + 0.5) / kSteps - 1);
      const double beyond = std::abs(offset + beside) - 1;
      if (beyond > 0) sum += std::pow(window(kernel.beta, 1 - beyond / kernel.width), 2);
    }
  }
  return std::sqrt(sum) / kSteps;
}

}  // namespace ensonify
