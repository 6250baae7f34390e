#include "acoustics/taps.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr double kEqualDelays_s = 1e-12;
constexpr double kLeastSpacing_cells = 0.6;  // of 1/b
constexpr double kGridSteps = 8;             // of the delays tried, in 1/b

// The fit by inner products alone: those of a tap on the grid of delays with the response, and
// those of two taps, which depend on the distance of their delays. The rest is kept orthogonal to
// the taps; `row` holds the Cholesky factor of their inner products.
class Pursuit {
 public:
  Pursuit(const TapFit& fit, std::span<const Complex> target)
      : fit_(fit), step_s_(1 / (kGridSteps * fit.bandwidth_hz)) {
    const auto steps = static_cast<std::size_t>((fit.delay_max_s - fit.delay_min_s) / step_s_) + 1;
    const double spacing = fit.bandwidth_hz / static_cast<double>(target.size());
    for (std::size_t i = 0; i < steps; ++i) {
      const double distance = static_cast<double>(i) * step_s_;
      const double sum =
          i == 0 ? static_cast<double>(target.size())
                 : std::sin(kPi * fit.bandwidth_hz * distance) / std::sin(kPi * spacing * distance);
      of_taps_.push_back(sum * std::polar(1.0, 2 * kPi * fit.frequency_hz * distance));
      of_target_.push_back(correlation(i, target));
    }
    rest_ = of_target_;
    free_.assign(steps, true);
    for (const Complex& t : target) left_ += std::norm(t);
  }

  // Energy of the response that the taps miss.
  double left() const { return left_; }
  std::size_t size() const { return chosen_.size(); }

  // Adds the tap that correlates best with the rest, at a distance from the others; false if there
  // is no place.
  bool add() {
    std::size_t best = rest_.size();
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      if (free_[i] && (best == rest_.size() || std::norm(rest_[i]) > std::norm(rest_[best])))
        best = i;
    }
    if (best == rest_.size()) return false;
    const std::vector<Complex>& row = new_row(best);
    // The new tap's part that is orthogonal to the others, as a sum of taps.
    std::vector<Complex> parts(row.size(), 0);
    parts.back() = 1 / row.back().real();
    for (std::size_t i = parts.size() - 1; i-- > 0;) {
      for (std::size_t m = i + 1; m < parts.size(); ++m) {
        parts[i] -= std::conj(rows_[m][i]) * parts[m];
      }
      parts[i] /= rows_[i][i].real();
    }
    const Complex along = rest_[best] / row.back().real();
    left_ = std::max(left_ - std::norm(along), 0.0);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const Complex factor = along * parts[k];
      for (std::size_t i = 0; i < rest_.size(); ++i) rest_[i] -= factor * between(i, chosen_[k]);
    }
    const auto near = static_cast<std::size_t>(std::ceil(kLeastSpacing_cells * kGridSteps)) - 1;
    const std::size_t end = std::min(best + near + 1, free_.size());
    for (std::size_t i = best - std::min(best, near); i < end; ++i) free_[i] = false;
    return true;
  }

  // The taps with the gains of least squares.
  std::vector<Tap> taps() const {
    const std::size_t n = chosen_.size();
    std::vector<Complex> x(n);
    for (std::size_t i = 0; i < n; ++i) {
      x[i] = of_target_[chosen_[i]];
      for (std::size_t m = 0; m < i; ++m) x[i] -= rows_[i][m] * x[m];
      x[i] /= rows_[i][i].real();
    }
    std::vector<Tap> taps(n);
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t m = i + 1; m < n; ++m) x[i] -= std::conj(rows_[m][i]) * x[m];
      x[i] /= rows_[i][i].real();
      taps[i] = {delay_s(chosen_[i]), x[i]};
    }
    std::ranges::sort(taps, {}, &Tap::delay_s);
    return taps;
  }

 private:
  double delay_s(std::size_t i) const {
    return fit_.delay_min_s + static_cast<double>(i) * step_s_;
  }

  // Inner product of tap i with the response; the phases are a geometric series.
  Complex correlation(std::size_t i, std::span<const Complex> target) const {
    const double spacing = fit_.bandwidth_hz / static_cast<double>(target.size());
    const double first = fit_.frequency_hz - (fit_.bandwidth_hz - spacing) / 2;
    const Complex step = std::polar(1.0, 2 * kPi * spacing * delay_s(i));
    Complex phase = std::polar(1.0, 2 * kPi * first * delay_s(i)), sum = 0;
    for (const Complex& t : target) {
      sum += phase * t;
      phase *= step;
    }
    return sum;
  }

  // Inner product of the taps i and k: sum e^(i 2 pi f (delay_i - delay_k)).
  Complex between(std::size_t i, std::size_t k) const {
    return i >= k ? of_taps_[i - k] : std::conj(of_taps_[k - i]);
  }

  const std::vector<Complex>& new_row(std::size_t tap) {
    chosen_.push_back(tap);
    const std::size_t i = rows_.size();
    std::vector<Complex>& row = rows_.emplace_back(i + 1);
    for (std::size_t k = 0; k <= i; ++k) {
      Complex sum = between(tap, chosen_[k]);
      for (std::size_t m = 0; m < k; ++m) sum -= row[m] * std::conj(rows_[k][m]);
      // Taps that are 0.6/b apart keep the matrix well conditioned.
      row[k] = k == i ? Complex(std::sqrt(std::max(sum.real(), 1e-12))) : sum / rows_[k][k].real();
    }
    return row;
  }

  const TapFit& fit_;
  double step_s_;
  std::vector<Complex> of_taps_, of_target_, rest_;  // [delays of the grid]
  std::vector<bool> free_;
  std::vector<std::size_t> chosen_;
  std::vector<std::vector<Complex>> rows_;
  double left_ = 0;
};

}  // namespace

std::vector<Tap> fit_taps(const std::function<Complex(double f_hz)>& response, const TapFit& fit) {
  ENSONIFY_ASSERT(fit.bandwidth_hz > 0 && fit.delay_max_s >= fit.delay_min_s && fit.most > 0);
  const double periods = fit.bandwidth_hz * (fit.delay_max_s - fit.delay_min_s);
  const std::size_t samples = static_cast<std::size_t>(std::ceil(2 * periods)) + 16;
  std::vector<Complex> target(samples);
  for (std::size_t i = 0; i < samples; ++i) {
    const double part = (static_cast<double>(i) + 0.5) / static_cast<double>(samples) - 0.5;
    target[i] = response(fit.frequency_hz + part * fit.bandwidth_hz);
  }
  Pursuit pursuit(fit, target);
  const double enough = fit.error * pursuit.left();
  while (static_cast<int>(pursuit.size()) < fit.most && pursuit.left() > enough) {
    if (!pursuit.add()) break;
  }
  return pursuit.taps();
}

std::vector<Tap> product(std::span<const Tap> a, std::span<const Tap> b, double least) {
  std::vector<Tap> taps;
  double all = 0;
  for (const Tap& x : a) {
    for (const Tap& y : b) {
      taps.push_back({x.delay_s + y.delay_s, x.gain * y.gain});
    }
  }
  // Delays are equal where a and b are the same wall.
  std::ranges::sort(taps, {}, &Tap::delay_s);
  std::size_t kept = 0;
  for (const Tap& tap : taps) {
    if (kept > 0 && tap.delay_s - taps[kept - 1].delay_s < kEqualDelays_s) {
      taps[kept - 1].gain += tap.gain;
    } else {
      taps[kept++] = tap;
    }
  }
  taps.resize(kept);
  for (const Tap& tap : taps) all += std::norm(tap.gain);
  std::erase_if(taps, [&](const Tap& tap) { return std::norm(tap.gain) < least * all; });
  return taps;
}

}  // namespace ensonify
