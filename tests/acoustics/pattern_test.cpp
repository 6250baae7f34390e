#include "acoustics/pattern.h"

#include <complex>
#include <vector>

#include "catch.h"

using namespace ensonify;

namespace {

double db(double amplitude) { return 20 * std::log10(std::abs(amplitude)); }

const BeamShading kUniform{Shading::uniform}, kHann{Shading::hann};
const BeamShading kTaylor{Shading::taylor, -35, 5}, kChebyshev{Shading::chebyshev, -35};

struct Lobe {
  double u = 0, level_db = 0;
};

// The first side lobes, by a fine search.
std::vector<Lobe> side_lobes(const ShadedLine& pattern, std::size_t count) {
  constexpr double kStep = 1e-3;
  std::vector<Lobe> lobes;
  for (double u = kStep; lobes.size() < count; u += kStep) {
    const double here = std::abs(shaded_line(pattern, u));
    if (here > std::abs(shaded_line(pattern, u - kStep)) &&
        here >= std::abs(shaded_line(pattern, u + kStep))) {
      lobes.push_back({u, db(here)});
    }
  }
  return lobes;
}

// The pattern of a line aperture with a given weight, by its integral over the aperture (midpoints,
// x in aperture lengths), relative to broadside.
template <class Weight>
double aperture_integral(const Weight& weight, double u) {
  constexpr int kPoints = 20000;
  double sum = 0, broadside = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double x = (i + 0.5) / kPoints - 0.5;
    sum += weight(x) * std::cos(2 * kPi * u * x);
    broadside += weight(x);
  }
  return sum / broadside;
}

}  // namespace

TEST_CASE("sinc is smooth through zero and signed") {
  CHECK(sinc(0) == 1);
  CHECK(sinc(3.1e-5) == Approx(sinc(3.2e-5)).epsilon(1e-8));
  CHECK(sinc(0.5) == Approx(2 / kPi));
  CHECK(sinc(1) == Approx(0).margin(1e-15));
  CHECK(sinc(1.5) == Approx(-2 / (3 * kPi)));
}

// Protects the meaning of a width: -3 dB from half a width off the axis on either side.
TEST_CASE("a pattern's width is its -3 dB full width") {
  for (const double width : {0.3, 1.0, 3.0}) {
    const double w = radians(width);
    CHECK(20 * std::log10(line_pattern(w / 2, w)) == Approx(-3.0).margin(0.03));
    CHECK(line_pattern(-w / 2, w) == line_pattern(w / 2, w));
  }
}

// Protects V2 and every old data set: a beam that is not shaded is the line of before.
TEST_CASE("the uniform receive pattern is the line pattern") {
  const ShadedLine pattern = make_shaded_line(kUniform, radians(1));
  for (const double angle : {0.0, 0.2, 0.5, 1.7, 30.0, -89.0}) {
    CHECK(shaded_pattern(pattern, radians(angle)) ==
          Approx(line_pattern(radians(angle), radians(1))).margin(1e-14));
  }
}

// Protects the meaning of a width under shading: half power at half the width, exactly where the
// sine of the angle is the angle.
TEST_CASE("shaded beams keep their -3 dB width") {
  for (const BeamShading& shading :
       {kHann, kTaylor, kChebyshev, BeamShading{Shading::taylor, -20, 2},
        BeamShading{Shading::chebyshev, -60}}) {
    const double width = 1e-4;
    const ShadedLine pattern = make_shaded_line(shading, width);
    INFO("shading " << static_cast<int>(shading.kind));
    CHECK(shaded_pattern(pattern, 0) == Approx(1).epsilon(1e-12));
    CHECK(shaded_pattern(pattern, width / 2) == Approx(std::sqrt(0.5)).epsilon(1e-8));
    CHECK(shaded_pattern(pattern, -width / 2) == shaded_pattern(pattern, width / 2));
    // Once down, the main lobe stays down.
    CHECK(std::abs(shaded_pattern(pattern, 0.55 * width)) < std::sqrt(0.5));
  }
}

// Protects the echoes of every sonar without a shaded elevation: to the bit the line of before.
TEST_CASE("the uniform elevation pattern is the line pattern") {
  Sonar sonar;
  sonar.elevation_width_rad = radians(20);
  for (const double angle : {0.0, 0.3, -7.2, 10.0, 27.0, -80.0}) {
    CHECK(elevation_pattern(sonar, radians(angle)) == line_pattern(radians(angle), radians(20)));
  }
}

// Protects the meaning of elevation.width_deg and of the levels of side lobes, which are those of
// both ways together, by closed forms: Hann's first zero is at u = 2, Chebyshev's first lobe where
// u^2 - A^2 = 1, Taylor's first lobe is near his level.
TEST_CASE("a shaded elevation pattern has its width, zeros and side lobes") {
  const double width = 0.01;
  const auto at = [&](const BeamShading& shading, double angle) {
    Sonar sonar;
    sonar.elevation_width_rad = width;
    sonar.elevation_line = make_shaded_line(shading, width);
    return elevation_pattern(sonar, angle);
  };
  for (const BeamShading& shading : {kHann, kTaylor, kChebyshev}) {
    CHECK(at(shading, 0) == Approx(1).epsilon(1e-12));
    CHECK(at(shading, width / 2) == Approx(std::sqrt(0.5)).epsilon(1e-5));
    CHECK(at(shading, -width / 2) == at(shading, width / 2));
  }
  const double hann_wavelengths = make_shaded_line(kHann, width).aperture;
  CHECK(hann_wavelengths * width / 2 == Approx(0.7203).epsilon(1e-4));
  CHECK(at(kHann, std::asin(2 / hann_wavelengths)) == Approx(0).margin(1e-12));
  const ShadedLine equal = make_shaded_line(kChebyshev, width);
  const double first_lobe = std::asin(std::sqrt(1 + equal.a_squared) / equal.aperture);
  CHECK(db(at(kChebyshev, first_lobe)) == Approx(-35).epsilon(1e-6));
  CHECK(at(kChebyshev, first_lobe) < 0);
  const ShadedLine taylor = make_shaded_line(kTaylor, width);
  const Lobe lobe = side_lobes(taylor, 1)[0];
  CHECK(db(at(kTaylor, std::asin(lobe.u / taylor.aperture))) == Approx(-35).margin(0.5));
}

// Protects the formula of the raised cosine, its whole value at u = 1 included.
TEST_CASE("hann shading is the integral over its aperture") {
  const auto weight = [](double x) { return 0.5 + 0.5 * std::cos(2 * kPi * x); };
  for (const double u : {0.3, 0.5, 0.999, 1.0, 1.001, 2.36, 7.5}) {
    CHECK(hann_line(u) == Approx(aperture_integral(weight, u)).margin(1e-8));
    CHECK(hann_line(-u) == hann_line(u));
  }
  CHECK(hann_line(1) == Approx(0.5).epsilon(1e-14));
}

// Protects Taylor's product against Taylor's aperture: the distribution whose Fourier coefficients
// are the pattern's own values at whole u below nbar is zero beyond, and gives the pattern between.
TEST_CASE("taylor shading is the integral over its aperture") {
  for (const auto& [side_lobe_db, nbar] : {std::pair{-35.0, 5}, {-25.0, 4}, {-50.0, 9}}) {
    const ShadedLine pattern = make_shaded_line({Shading::taylor, side_lobe_db, nbar}, radians(1));
    const auto weight = [&, nbar = nbar](double x) {
      double sum = 1;
      for (int m = 1; m < nbar; ++m) {
        sum += 2 * shaded_line(pattern, m) * std::cos(2 * kPi * m * x);
      }
      return sum;
    };
    for (const double u : {0.2, 0.7, 1.0, 1.4, 2.0, 3.3, 4.0, 4.6, 8.5, 20.5}) {
      INFO(side_lobe_db << " dB, " << nbar << ", u " << u);
      CHECK(shaded_line(pattern, u) == Approx(aperture_integral(weight, u)).margin(1e-6));
    }
  }
}

// Protects the removable poles: no jump where the sine and a factor vanish together.
TEST_CASE("shaded patterns are smooth through whole u") {
  for (const BeamShading& shading : {kHann, kTaylor}) {
    const ShadedLine pattern = make_shaded_line(shading, radians(1));
    for (int n = 1; n <= 6; ++n) {
      const double left = shaded_line(pattern, n - 1e-5), right = shaded_line(pattern, n + 1e-5);
      CHECK(shaded_line(pattern, n) == Approx((left + right) / 2).margin(1e-9));
    }
  }
}

// Protects the limit's claim against the array that it is the limit of: Dolph's weights make
// T_{N-1}(x_0 cos(pi u / N)) / T_{N-1}(x_0), with N elements u = N d sin(angle)/lambda.
TEST_CASE("chebyshev shading is the limit of Dolph's array") {
  const ShadedLine pattern = make_shaded_line(kChebyshev, radians(1));
  constexpr int kElements = 4001;
  const double ratio = std::pow(10.0, 35.0 / 20);
  const double x0 = std::cosh(std::acosh(ratio) / (kElements - 1));
  for (const double u : {0.0, 0.5, 1.0, 1.5, 1.81, 2.5, 6.19, 12.0}) {
    const double x = x0 * std::cos(kPi * u / kElements);
    const double order = kElements - 1;
    const double polynomial =
        x > 1 ? std::cosh(order * std::acosh(x)) : std::cos(order * std::acos(x));
    CHECK(shaded_line(pattern, u) == Approx(polynomial / ratio).margin(1e-3));
  }
}

// Protects the table of docs/physics/3_beams.md: aperture and first side lobe of each shading.
TEST_CASE("apertures and first side lobes of the shadings") {
  struct Row {
    BeamShading shading;
    double aperture_widths, lobe_db, lobe_widths;
  };
  for (const Row& row : {Row{kUniform, 0.884, -13.26, 1.62}, Row{kHann, 1.441, -31.47, 1.64},
                         Row{kTaylor, 1.187, -35.22, 1.60}, Row{kChebyshev, 1.131, -35.00, 1.60}}) {
    const ShadedLine pattern = make_shaded_line(row.shading, radians(1));
    const double factor = pattern.aperture * radians(1);
    CHECK(factor == Approx(row.aperture_widths).margin(0.0005));
    const Lobe first = side_lobes(pattern, 1).front();
    CHECK(first.level_db == Approx(row.lobe_db).margin(0.005));
    CHECK(first.u / factor == Approx(row.lobe_widths).margin(0.005));
  }
}

// Protects what the shadings are chosen for: Taylor's lobes up to nbar near the wanted level, then
// falling; all of Chebyshev's at it.
TEST_CASE("side lobes of taylor and chebyshev lie where they were wanted") {
  const auto taylor = side_lobes(make_shaded_line(kTaylor, radians(1)), 12);
  for (int n = 0; n < 4; ++n) CHECK(taylor[n].level_db == Approx(-35.8).margin(0.8));
  for (int n = 4; n < 11; ++n) CHECK(taylor[n + 1].level_db < taylor[n].level_db - 0.5);
  for (const double level : {-20.0, -35.0, -50.0}) {
    const ShadedLine pattern = make_shaded_line({Shading::chebyshev, level}, radians(1));
    for (const Lobe& lobe : side_lobes(pattern, 12)) {
      CHECK(lobe.level_db == Approx(level).margin(1e-3));
    }
  }
}

// Protects the transmit beam: half power at exactly half the width on either side, however wide.
TEST_CASE("the transmit pattern") {
  for (const double width : {1.0, 20.0, 90.0, 180.0}) {
    const double w = radians(width);
    CHECK(transmit_pattern(0, w) == 1);
    CHECK(transmit_pattern(w / 2, w) == Approx(std::sqrt(0.5)).epsilon(1e-9));
    CHECK(transmit_pattern(-w / 2, w) == transmit_pattern(w / 2, w));
  }
  CHECK(transmit_pattern(radians(70), 0) == 1);
  // First null of a 20 degree beam: sin(azimuth) = sin(10 degrees)/0.4429464707.
  const double null = std::asin(std::sin(radians(10)) / 0.4429464707);
  CHECK(transmit_pattern(null, radians(20)) == Approx(0).margin(1e-12));
  CHECK(transmit_pattern(null + 0.1, radians(20)) < 0);
}

// Protects the array's calibration (weights sum to 1, so that a focused echo keeps its level) and
// that its beams are those of the continuous line: equal at every whole u below half the elements,
// where Woodward and Lawson fix them.
TEST_CASE("element weights give the continuous line's pattern") {
  for (const BeamShading& shading : {kUniform, kHann, kTaylor}) {
    for (const int elements : {1, 2, 3, 20, 101}) {
      INFO(name_of(shading.kind) << ", " << elements << " elements");
      const std::vector<double> weights = array_weights(shading, elements);
      REQUIRE(weights.size() == static_cast<std::size_t>(elements));
      const ShadedLine pattern = make_shaded_line(shading, radians(1));
      for (int u = 0; 2 * u < elements; ++u) {
        std::complex<double> sum = 0;
        for (int n = 0; n < elements; ++n) {
          sum += weights[n] * std::polar(1.0, 2 * kPi * u * (n - (elements - 1) / 2.0) / elements);
        }
        CHECK(std::abs(sum - shaded_line(pattern, u)) < 1e-12);
      }
    }
  }
  for (const double weight : array_weights(kUniform, 101)) CHECK(weight == Approx(1 / 101.0));
}

// The side lobes between those points: within 0.5 dB of the continuous line's for 101 elements.
TEST_CASE("element weights keep the shading's side lobes") {
  for (const BeamShading& shading : {kUniform, kHann, kTaylor}) {
    INFO(name_of(shading.kind));
    const std::vector<double> weights = array_weights(shading, 101);
    for (const Lobe& lobe : side_lobes(make_shaded_line(shading, radians(1)), 4)) {
      double sum = 0;
      for (int n = 0; n < 101; ++n) sum += weights[n] * std::cos(2 * kPi * lobe.u * (n - 50) / 101);
      CHECK(db(sum) == Approx(lobe.level_db).margin(0.5));
    }
  }
}

// Protects Dolph's array: every side lobe as high as asked for, whatever the number of elements,
// and real weights about the middle whose sum is 1.
TEST_CASE("chebyshev weights have equal side lobes") {
  for (const int elements : {1, 2, 7, 20, 101}) {
    INFO(elements << " elements");
    const std::vector<double> weights = array_weights(kChebyshev, elements);
    double total = 0;
    for (int n = 0; n < elements; ++n) {
      total += weights[n];
      CHECK(weights[n] == Approx(weights[elements - 1 - n]));
    }
    CHECK(total == Approx(1));
    std::vector<double> lobes;
    double before = 1, last = 1;
    for (double u = 1e-3; u < elements / 2.0; u += 1e-3) {
      double sum = 0;
      for (int n = 0; n < elements; ++n) {
        sum += weights[n] * std::cos(2 * kPi * u * (n - (elements - 1) / 2.0) / elements);
      }
      if (last > before && last >= std::abs(sum)) lobes.push_back(db(last));
      before = last;
      last = std::abs(sum);
    }
    if (elements > 2) CHECK(lobes.size() + 2 >= static_cast<std::size_t>(elements / 2));
    for (const double lobe : lobes) CHECK(lobe == Approx(-35).margin(0.01));
  }
}

// Protects echoes that come back from another elevation than they were sent to.
TEST_CASE("the two-way pattern of equal directions is the pattern") {
  const double at = line_pattern(0.05, 0.1);
  for (const double x : {-0.6, -0.3, 0.0, 0.05, 0.5}) {
    const double once = line_pattern(x, 0.1);
    CHECK(two_direction_pattern(once, once) == once);
    CHECK(std::abs(two_direction_pattern(at, once)) == Approx(std::sqrt(std::abs(once * at))));
    CHECK((two_direction_pattern(at, once) < 0) == (once < 0));
  }
}
