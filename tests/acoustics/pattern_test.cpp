#include "acoustics/pattern.h"

#include "catch.h"

using namespace ensonify;

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
