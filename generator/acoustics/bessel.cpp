#include "acoustics/bessel.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace ensonify {
namespace {

constexpr int kExponentStep = 300;  // exponents change by this much, so that neighbors can be added

// Two neighboring orders with a common exponent.
struct BesselPair {
  double last, next;
  int exponent = 0;

  void advance(double value) {
    last = std::exchange(next, value);
    if (std::abs(next) < std::ldexp(1.0, kExponentStep)) return;
    last = std::ldexp(last, -kExponentStep);
    next = std::ldexp(next, -kExponentStep);
    exponent += kExponentStep;
  }
};

BesselValue normalized(BesselValue f, double factor, int exponent) {
  return {f.value * factor, f.slope * factor, f.exponent + exponent};
}

// f_(n-1) + f_(n+1) = (2n + odd)/x f_n: odd is 1 for spherical functions and 0 for cylindrical ones.
// `value0` and `slope0` are those of order 0. Scaled by the larger of both, which are not 0 together.
std::vector<BesselValue> downward(int orders, double x, int odd, double value0, double slope0) {
  ENSONIFY_ASSERT(orders > 0 && x > 0);
  // From `most` on, the ratio to the function of the second kind has fallen by e^-41.
  const double most = std::max<double>(orders, x);
  const int start = static_cast<int>(std::ceil(most + 9 * std::cbrt(most) + 16));
  std::vector<BesselValue> j(static_cast<std::size_t>(orders));
  BesselPair pair{0, 1};
  for (int n = start; n >= 0; --n) {
    // `pair.next` is of order n, `pair.last` of order n + 1
    if (n < orders) {
      j[static_cast<std::size_t>(n)] = {pair.next, n * pair.next - x * pair.last, pair.exponent};
    }
    if (n > 0) pair.advance((2 * n + odd) / x * pair.next - pair.last);
  }
  // For small x the slope would cancel.
  const bool by_value = x < 1 || std::abs(value0) > std::abs(slope0) / x;
  const double factor = by_value ? value0 / j[0].value : slope0 / j[0].slope;
  const int exponent = -j[0].exponent;
  for (BesselValue& f : j) f = normalized(f, factor, exponent);
  return j;
}

std::vector<BesselValue> upward(int orders, double x, int odd, BesselPair pair) {
  ENSONIFY_ASSERT(orders > 0 && x > 0);
  std::vector<BesselValue> y(static_cast<std::size_t>(orders));
  for (int n = 0; n < orders; ++n) {
    // `pair.last` is of order n, `pair.next` of order n + 1
    y[static_cast<std::size_t>(n)] = {pair.last, n * pair.last - x * pair.next, pair.exponent};
    pair.advance((2 * n + 2 + odd) / x * pair.next - pair.last);
  }
  return y;
}

}  // namespace

std::vector<BesselValue> spherical_j(int orders, double x) {
  const double j0 = std::sin(x) / x;
  return downward(orders, x, 1, j0, std::cos(x) - j0);
}

std::vector<BesselValue> spherical_y(int orders, double x) {
  return upward(orders, x, 1, {-std::cos(x) / x, -std::cos(x) / (x * x) - std::sin(x) / x});
}

std::vector<BesselValue> cylindrical_j(int orders, double x) {
  return downward(orders, x, 0, std::cyl_bessel_j(0, x), -x * std::cyl_bessel_j(1, x));
}

std::vector<BesselValue> cylindrical_y(int orders, double x) {
  return upward(orders, x, 0, {std::cyl_neumann(0, x), std::cyl_neumann(1, x)});
}

}  // namespace ensonify
