#include "acoustics/propagation.h"

#include "catch.h"

using namespace ensonify;

// Protects the sonar equation: 40 log r and 2 alpha r in the level.
TEST_CASE("two-way loss is 40 log r and absorption over both ways") {
  CHECK(20 * std::log10(two_way_loss(5, 0)) == Approx(-40 * std::log10(5)));
  CHECK(20 * std::log10(two_way_loss(10, 0.3)) == Approx(-40 - 0.3 * 20));
}

// Protects coherence at long range: the fraction of a turn keeps its digits after 72,000 turns.
TEST_CASE("carrier turns are reduced in double") {
  const double delay = two_way_delay_s(60, 1500);
  CHECK(carrier_turns(900e3, delay) == Approx(0).margin(1e-9));
  // A quarter of a wavelength further away: half a turn more on the way out and back.
  const double wavelength = 1500 / 900e3;
  CHECK(std::abs(carrier_turns(900e3, two_way_delay_s(60 + wavelength / 4, 1500))) ==
        Approx(0.5).margin(1e-9));
  CHECK(carrier_turns(900e3, two_way_delay_s(60 + wavelength / 10, 1500)) ==
        Approx(0.2).margin(1e-9));
}
