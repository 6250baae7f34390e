#include "scenario/keyed_numbers.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "scenario/reader.h"

namespace ensonify {
namespace {

// In standard deviations of a normal distribution.
constexpr double kExtremeDeviation = 3;

double normal_of(const KeyedNumbers& numbers, double mean, double deviation, const Way& way) {
  if (numbers.extreme != nullptr) {
    return mean + (numbers.extreme->is_upper ? deviation : -deviation) * kExtremeDeviation;
  }
  return mean + deviation * std::sqrt(2.0) * complex_normal(numbers.key, 0, way.key, 0).re;
}

}  // namespace

Way step(const Way& way, std::string_view segment, std::string_view name) {
  return {mix64(way.key ^ name_key(name)), joined_path(way.path, segment),
          joined_path(way.named, name)};
}

Way step(const Way& way, std::string_view segment) { return step(way, segment, segment); }

Way alternative(const Way& way, std::size_t index) {
  Way inner = step(step(way, "choice"), std::to_string(index));
  inner.named = way.named;
  return inner;
}

double KeyedNumbers::uniform_of(const Way& way) const {
  if (extreme != nullptr) return uniform_from_word(extreme->is_upper ? UINT32_MAX : 0);
  return uniform(key, 0, way.key, 0);
}

double KeyedNumbers::drawn(std::string_view kind, const std::array<double, 2>& given,
                           const Way& way) const {
  const auto [a, b] = given;
  if (kind == "normal") return normal_of(*this, a, b, way);
  const double u = uniform_of(way);
  const double value =
      kind == "uniform" ? a + u * (b - a) : std::exp(std::log(a) + u * (std::log(b) - std::log(a)));
  return std::clamp(value, a, b);
}

}  // namespace ensonify
