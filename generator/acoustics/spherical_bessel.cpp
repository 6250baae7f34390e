#include "acoustics/spherical_bessel.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace ensonify {
namespace {

constexpr int kStep = 300;  // exponents change by this much, so that neighbors can be added

// Two neighboring orders with a common exponent.
struct BesselPair {
  double last, next;
  int exponent = 0;

  void advance(double value) {
    last = std::exchange(next, value);
    if (std::abs(next) < std::ldexp(1.0, kStep)) return;
    last = std::ldexp(last, -kStep);
    next = std::ldexp(next, -kStep);
    exponent += kStep;
  }
};

BesselValue normalized(BesselValue f, double factor, int exponent) {
  return {f.value * factor, f.slope * factor, f.exponent + exponent};
}

}  // namespace

std::vector<BesselValue> spherical_j(int orders, double x) {
  ENSONIFY_ASSERT(orders > 0 && x > 0);
  // From `most` on j_n/y_n has fallen by e^-41.
  const double most = std::max<double>(orders, x);
  const int start = static_cast<int>(std::ceil(most + 9 * std::cbrt(most) + 16));
  std::vector<BesselValue> j(static_cast<std::size_t>(orders));
  BesselPair pair{0, 1};
  for (int n = start; n >= 0; --n) {
    // `pair.next` is j_n, `pair.last` is j_(n+1)
    if (n < orders) {
      j[static_cast<std::size_t>(n)] = {pair.next, n * pair.next - x * pair.last, pair.exponent};
    }
    if (n > 0) pair.advance((2 * n + 1) / x * pair.next - pair.last);
  }
  // Scaled by the larger one of j_0 and x j_0' = cos x - sin x/x, which are not 0 together. For
  // small x the second one would cancel.
  const double j0 = std::sin(x) / x, slope0 = std::cos(x) - j0;
  const bool by_value = x < 1 || std::abs(j0) > std::abs(slope0) / x;
  const double factor = by_value ? j0 / j[0].value : slope0 / j[0].slope;
  const int exponent = -j[0].exponent;
  for (BesselValue& f : j) f = normalized(f, factor, exponent);
  return j;
}

std::vector<BesselValue> spherical_y(int orders, double x) {
  ENSONIFY_ASSERT(orders > 0 && x > 0);
  std::vector<BesselValue> y(static_cast<std::size_t>(orders));
  BesselPair pair{-std::cos(x) / x, -std::cos(x) / (x * x) - std::sin(x) / x};
  for (int n = 0; n < orders; ++n) {
    // `pair.last` is y_n, `pair.next` is y_(n+1)
    y[static_cast<std::size_t>(n)] = {pair.last, n * pair.last - x * pair.next, pair.exponent};
    pair.advance((2 * n + 3) / x * pair.next - pair.last);
  }
  return y;
}

}  // namespace ensonify
