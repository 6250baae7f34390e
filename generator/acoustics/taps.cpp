#include "acoustics/taps.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr double kLeastSpacing_cells = 0.6;  // of 1/b
constexpr double kGridSteps = 8;             // of the delays tried, in 1/b

// The response of a unit tap at the frequencies of the fit: a geometric series.
std::vector<Complex> unit_tap(double delay_s, std::span<const double> f_hz) {
  const Complex step = std::polar(1.0, -2 * kPi * (f_hz[1] - f_hz[0]) * delay_s);
  std::vector<Complex> tap(f_hz.size());
  Complex value = std::polar(1.0, -2 * kPi * f_hz[0] * delay_s);
  for (Complex& t : tap) {
    t = value;
    value *= step;
  }
  return tap;
}

Complex correlation(std::span<const Complex> a, std::span<const Complex> b) {
  Complex sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::conj(a[i]) * b[i];
  return sum;
}

double energy(std::span<const Complex> x) { return correlation(x, x).real(); }

// Solves the normal equations of the taps by Cholesky's method. Taps that are 0.6/b apart keep the
// matrix well conditioned.
std::vector<Complex> solve_gains(const std::vector<std::vector<Complex>>& taps,
                                 std::span<const Complex> target) {
  const std::size_t n = taps.size();
  std::vector<std::vector<Complex>> lower(n, std::vector<Complex>(n));
  std::vector<Complex> x(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k <= i; ++k) {
      Complex sum = correlation(taps[i], taps[k]);
      for (std::size_t m = 0; m < k; ++m) sum -= lower[i][m] * std::conj(lower[k][m]);
      lower[i][k] = i == k ? Complex(std::sqrt(std::max(sum.real(), 1e-12))) : sum / lower[k][k];
    }
    Complex sum = correlation(taps[i], target);
    for (std::size_t m = 0; m < i; ++m) sum -= lower[i][m] * x[m];
    x[i] = sum / lower[i][i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t m = i + 1; m < n; ++m) x[i] -= std::conj(lower[m][i]) * x[m];
    x[i] /= lower[i][i];
  }
  return x;
}

// The delay on the grid whose tap correlates best with the rest and keeps its distance from the
// other taps.
double best_delay(std::span<const Complex> rest, std::span<const double> f_hz, const TapFit& fit,
                  std::span<const Tap> taken) {
  const double step = 1 / (kGridSteps * fit.bandwidth_hz);
  const int steps = static_cast<int>((fit.delay_max_s - fit.delay_min_s) / step);
  double best = NAN, most = -1;
  for (int i = 0; i <= steps; ++i) {
    const double delay = fit.delay_min_s + i * step;
    const bool near = std::ranges::any_of(taken, [&](const Tap& tap) {
      return std::abs(tap.delay_s - delay) < kLeastSpacing_cells / fit.bandwidth_hz;
    });
    if (near) continue;
    const double found = std::norm(correlation(unit_tap(delay, f_hz), rest));
    if (found > most) {
      most = found;
      best = delay;
    }
  }
  return best;
}

}  // namespace

std::vector<Tap> fit_taps(const std::function<Complex(double f_hz)>& response, const TapFit& fit) {
  ENSONIFY_ASSERT(fit.bandwidth_hz > 0 && fit.delay_max_s >= fit.delay_min_s && fit.most > 0);
  const double periods = fit.bandwidth_hz * (fit.delay_max_s - fit.delay_min_s);
  const std::size_t samples = static_cast<std::size_t>(std::ceil(2 * periods)) + 16;
  std::vector<double> f_hz(samples);
  std::vector<Complex> target(samples);
  for (std::size_t i = 0; i < samples; ++i) {
    const double part = (static_cast<double>(i) + 0.5) / static_cast<double>(samples) - 0.5;
    f_hz[i] = fit.frequency_hz + part * fit.bandwidth_hz;
    target[i] = response(f_hz[i]);
  }
  const double all = energy(target);
  std::vector<Tap> taps;
  std::vector<std::vector<Complex>> columns;
  std::vector<Complex> rest = target;
  while (static_cast<int>(taps.size()) < fit.most && energy(rest) > fit.error * all) {
    const double delay = best_delay(rest, f_hz, fit, taps);
    if (!std::isfinite(delay)) break;
    taps.push_back({delay, 0});
    columns.push_back(unit_tap(delay, f_hz));
    const std::vector<Complex> gains = solve_gains(columns, target);
    rest = target;
    for (std::size_t k = 0; k < taps.size(); ++k) {
      taps[k].gain = gains[k];
      for (std::size_t i = 0; i < samples; ++i) rest[i] -= gains[k] * columns[k][i];
    }
  }
  std::ranges::sort(taps, {}, &Tap::delay_s);
  return taps;
}

std::vector<Tap> product(std::span<const Tap> a, std::span<const Tap> b, double least) {
  std::vector<Tap> taps;
  double all = 0;
  for (const Tap& x : a) {
    for (const Tap& y : b) {
      taps.push_back({x.delay_s + y.delay_s, x.gain * y.gain});
      all += std::norm(taps.back().gain);
    }
  }
  std::erase_if(taps, [&](const Tap& tap) { return std::norm(tap.gain) < least * all; });
  std::ranges::sort(taps, {}, &Tap::delay_s);
  return taps;
}

}  // namespace ensonify
