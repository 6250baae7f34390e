#include "acoustics/propagation.h"

#include "catch.h"

using namespace ensonify;

// V9: Francois-Garrison absorption at 10 C, 35 psu, pH 8 at the surface.
TEST_CASE("V9: absorption of sea water") {
  const SeaWater water{10, 35, 8, 0};
  CHECK(francois_garrison_db_m(100e3, water) == Approx(0.0336).epsilon(0.01));
  CHECK(francois_garrison_db_m(400e3, water) == Approx(0.0961).epsilon(0.01));
  CHECK(francois_garrison_db_m(900e3, water) == Approx(0.2995).epsilon(0.01));
  CHECK(francois_garrison_db_m(1200e3, water) == Approx(0.4954).epsilon(0.01));
  CHECK(francois_garrison_db_m(2100e3, water) == Approx(1.4186).epsilon(0.01));
}

// Protects against a slip in a term that the table above does not feel: fresh water loses the
// salts' part, depth lowers absorption, and both branches of the water term meet at 20 C.
TEST_CASE("absorption follows salinity, depth and temperature") {
  CHECK(francois_garrison_db_m(100e3, {10, 0, 7, 0}) == Approx(3.09e-4 * 10).epsilon(0.02));
  CHECK(francois_garrison_db_m(400e3, {10, 35, 8, 2000}) <
        francois_garrison_db_m(400e3, {10, 35, 8, 0}));
  CHECK(francois_garrison_db_m(900e3, {20, 35, 8, 0}) ==
        Approx(francois_garrison_db_m(900e3, {20.0001, 35, 8, 0})).epsilon(0.005));
}

// Protects the second formula by the first: they differ by less than a tenth where both hold
// (Ainslie and McColm state it), in any water.
TEST_CASE("Ainslie-McColm follows Francois-Garrison") {
  for (const SeaWater& water : {SeaWater{10, 35, 8, 0}, SeaWater{25, 38, 8.2, 0},
                                SeaWater{4, 34, 7.8, 3000}, SeaWater{-1, 33, 8, 500}}) {
    for (const double frequency_hz : {10e3, 50e3, 100e3, 300e3, 900e3}) {
      INFO(water.temperature_c << " C, " << frequency_hz << " Hz");
      CHECK(ainslie_mccolm_db_m(frequency_hz, water) ==
            Approx(francois_garrison_db_m(frequency_hz, water)).epsilon(0.1));
    }
  }
}

// Protects ranges: sound speed against the check value of another published formula (Mackenzie
// 1981: 1550.744 m/s at 25 C, 35 psu, 1000 m), against distilled water (1482.34 m/s
// at 20 C) and against the mean ocean at the surface (Mackenzie at 10 C, 35 psu: 1489.80 m/s).
TEST_CASE("sound speed from temperature, salinity and depth") {
  CHECK(sound_speed_m_s({25, 35, 8, 1000}) == Approx(1550.744).margin(0.4));
  CHECK(sound_speed_m_s({20, 0, 8, 0}) == Approx(1482.34).margin(0.2));
  CHECK(sound_speed_m_s({10, 35, 8, 0}) == Approx(1489.80).margin(0.2));
}

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
