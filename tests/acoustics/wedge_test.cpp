// Protects: the diffraction of wedges, against the exact series for a plane wave, and that what is
// added to Kirchhoff's integral is finite and smooth.
#include "acoustics/scattering.h"

#include <cmath>
#include <complex>

#include "catch.h"
#include "core/units.h"

namespace ensonify {
namespace {

// The diffracted field of a plane wave from `angle`, heard at the same angle and k rho = `distance`
// from the edge: the whole field (MacDonald's series) without the incident and reflected waves.
std::complex<double> exact_diffracted(const Wedge& wedge, double angle, double distance) {
  const double n = wedge.exterior_rad / kPi;
  std::complex<double> sum = 0;
  for (int m = 0; m / n < distance + 60; ++m) {
    const double order = m / n, weight = m == 0 ? 1 : 2;
    const double shape = wedge.rigid ? std::pow(std::cos(order * angle), 2)
                                     : std::pow(std::sin(order * angle), 2);
    sum += weight * std::polar(1.0, -kPi / 2 * order) * std::cyl_bessel_j(order, distance) * shape;
  }
  sum *= 2 / n;
  sum -= std::polar(1.0, -distance);
  const double sign = wedge.rigid ? 1 : -1, other = wedge.exterior_rad - angle;
  if (angle < kPi / 2) sum -= sign * std::polar(1.0, -distance * std::cos(2 * angle));
  if (other < kPi / 2) sum -= sign * std::polar(1.0, -distance * std::cos(2 * other));
  return sum;
}

TEST_CASE("wedge diffraction against the exact field of a plane wave") {
  constexpr double kDistance = 400;  // k rho; the next order is about 1/distance
  for (const double exterior_deg : {270.0, 360.0, 240.0}) {
    for (const bool rigid : {true, false}) {
      const Wedge wedge{radians(exterior_deg), rigid};
      for (const double deg : {20.0, 50.0, 115.0, 135.0}) {
        const std::complex<double> expected =
            wedge_diffraction(wedge, radians(deg)) *
            std::polar(1 / std::sqrt(2 * kPi * kDistance), kDistance + kPi / 4);
        const std::complex<double> exact = exact_diffracted(wedge, radians(deg), kDistance);
        CAPTURE(exterior_deg, rigid, deg);
        CHECK(std::abs(exact - expected) < 0.02 * std::abs(expected) + 3e-4);
      }
    }
  }
}

TEST_CASE("the fringe is the rest of Kirchhoff's integral, finite where both have poles") {
  for (const double exterior_deg : {240.0, 270.0, 360.0}) {
    for (const bool rigid : {true, false}) {
      const Wedge wedge{radians(exterior_deg), rigid};
      double before = fringe_diffraction(wedge, radians(0.5));
      for (double deg = 1; deg < exterior_deg; deg += 0.5) {
        const double fringe = fringe_diffraction(wedge, radians(deg));
        CHECK(std::abs(fringe) <= 1);
        CHECK(fringe == Approx(before).margin(0.02));
        before = fringe;
      }
      const double far = radians(70);
      CHECK(fringe_diffraction(wedge, far) ==
            Approx(wedge_diffraction(wedge, far) - kirchhoff_edge(wedge, far)));
      // Both faces are alike.
      CHECK(fringe_diffraction(wedge, far) ==
            Approx(fringe_diffraction(wedge, wedge.exterior_rad - far)));
    }
  }
}

// In two dimensions, the far edge of a rigid plate seen at alpha from its normal has the Kirchhoff
// amplitude -cot(alpha)/(4 pi) per length, and the near edge the opposite one.
TEST_CASE("Kirchhoff's edges of a plate") {
  const Wedge sheet{2 * kPi, true};
  for (const double deg : {10.0, 40.0, 80.0}) {
    const double cotangent = 1 / std::tan(radians(deg));
    CHECK(kirchhoff_edge(sheet, radians(90 - deg)) == Approx(-cotangent / 2));
    CHECK(kirchhoff_edge(sheet, radians(90 + deg)) == Approx(cotangent / 2));
  }
}

}  // namespace
}  // namespace ensonify
