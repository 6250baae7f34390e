#include "figure/ticks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ensonify {

double tick_step(double span, int most) {
  const double decade = std::pow(10.0, std::floor(std::log10(span / most)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade * most >= span * (1 - 1e-9)) return factor * decade;
  }
  return 10 * decade;
}

std::vector<double> ticks_in(double end, double other_end, double step) {
  const double low = std::min(end, other_end), high = std::max(end, other_end);
  std::vector<double> ticks;
  // Counted in steps, so that no error adds up.
  for (double n = std::ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; ++n) {
    ticks.push_back(n == 0 ? 0.0 : n * step);
  }
  return ticks;
}

std::string tick_text(double value, double step) {
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  const std::string text = fmt::format("{:.{}f}", std::abs(value), decimals);
  const bool is_zero = text.find_first_not_of("0.") == std::string::npos;
  return value < 0 && !is_zero ? "\xe2\x88\x92" + text : text;
}

}  // namespace ensonify
