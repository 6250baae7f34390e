#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "core/random.h"
#include "sweep/axes.h"

namespace ensonify {
namespace {

double rounded(double value, int significant_digits) {
  const std::string text = fmt::format("{:.{}e}", value, significant_digits - 1);
  double back = value;
  std::from_chars(text.data(), text.data() + text.size(), back);
  return back;
}

constexpr int kRandomDigits = 6;

double log_between(double a, double b, double share) {
  const double value = std::exp(std::log(a) + share * (std::log(b) - std::log(a)));
  return std::clamp(rounded(value, kRandomDigits), a, b);
}

}  // namespace

std::vector<double> linear_values(double a, double b, int count) {
  std::vector<double> values = {a};
  for (int i = 1; i < count; ++i) {
    const double share = static_cast<double>(i) / (count - 1);
    values.push_back(i + 1 == count ? b : rounded(a * (1 - share) + b * share, 15));
  }
  return values;
}

std::vector<double> log_values(double a, double b, int count) {
  std::vector<double> values = {a};
  for (int i = 1; i < count; ++i) {
    const double share = static_cast<double>(i) / (count - 1);
    const double value = a < b ? log_between(a, b, share) : log_between(b, a, 1 - share);
    values.push_back(i + 1 == count ? b : value);
  }
  return values;
}

std::vector<double> uniform_values(double a, double b, int count, std::uint64_t key, bool whole) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) {
    const double share = uniform(key, 0, static_cast<std::uint64_t>(i), 0);
    const double value =
        whole ? std::floor(a + share * (b - a + 1)) : rounded(a + share * (b - a), kRandomDigits);
    values.push_back(std::clamp(value, a, b));
  }
  return values;
}

std::vector<double> log_uniform_values(double a, double b, int count, std::uint64_t key) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) {
    values.push_back(log_between(a, b, uniform(key, 0, static_cast<std::uint64_t>(i), 0)));
  }
  return values;
}

}  // namespace ensonify
