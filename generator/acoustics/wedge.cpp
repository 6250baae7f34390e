#include "acoustics/wedge.h"

#include <cmath>
#include <initializer_list>

#include "core/units.h"

namespace ensonify {

double wedge_diffraction(const Wedge& wedge, double angle_rad) {
  const double n = wedge.exterior_rad / kPi;
  const double cosine = std::cos(kPi / n);
  const double away = 1 / (cosine - 1), back = 1 / (cosine - std::cos(2 * angle_rad / n));
  return std::sin(kPi / n) / n * (wedge.rigid ? away + back : away - back);
}

double kirchhoff_edge(const Wedge& wedge, double angle_rad) {
  const double other_rad = wedge.exterior_rad - angle_rad;
  double sum = 0;
  if (angle_rad < kPi) sum += std::tan(angle_rad) / 2;
  if (other_rad < kPi) sum += std::tan(other_rad) / 2;
  return wedge.rigid ? -sum : sum;
}

double fringe_diffraction(const Wedge& wedge, double angle_rad) {
  constexpr double kNear_rad = 1e-4;  // of normal incidence, where both terms have a pole
  const auto difference = [&](double a) {
    return wedge_diffraction(wedge, a) - kirchhoff_edge(wedge, a);
  };
  for (const double pole : {kPi / 2, wedge.exterior_rad - kPi / 2}) {
    if (std::abs(angle_rad - pole) < kNear_rad) {
      return (difference(pole - kNear_rad) + difference(pole + kNear_rad)) / 2;
    }
  }
  return difference(angle_rad);
}

}  // namespace ensonify
