#include "core/sonar.h"

#include <cmath>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

Sonar p900() {
  Sonar sonar;
  sonar.frequency_hz = 900e3;
  sonar.bandwidth_hz = 29.9e3;
  sonar.range_max_m = 60;
  sonar.beam_count = 512;
  sonar.beam_spacing_rad = radians(90) / 512;
  return sonar;
}

}  // namespace

// Protects the record: N = ceil(b 2R / c) samples, and transforms long enough that the last echo
// does not come back in the first samples.
TEST_CASE("the record of the paper's sonar") {
  const Record record = make_record(p900(), Water{1500, 0}, 0);
  CHECK(record.samples == 2392);
  CHECK(record.transform == 2500);
  CHECK(record.sample_interval_s == Approx(1 / 29.9e3));
  Sonar ten = p900();
  ten.range_max_m = 10;
  CHECK(make_record(ten, Water{1500, 0}, 0).samples == 399);
  CHECK(sample_range_m(p900(), Water{1500, 0}, 299) == Approx(7.5));
}

// Protects the start of the record from a long pulse: the padding grows by the pulse, the stored
// samples do not. 1 ms is 29.9 samples: 399 + 64 + 30 = 493, then 500.
TEST_CASE("a long pulse makes the transform longer") {
  Sonar ten = p900();
  ten.range_max_m = 10;
  CHECK(make_record(ten, Water{1500, 0}, 0).transform == 480);
  CHECK(make_record(ten, Water{1500, 0}, 1e-3).transform == 500);
  CHECK(make_record(ten, Water{1500, 0}, 1e-3).samples == 399);
}

TEST_CASE("transform lengths are the smallest even 2-3-5-smooth ones") {
  CHECK(smooth_even_length(1) == 2);
  CHECK(smooth_even_length(7) == 8);
  CHECK(smooth_even_length(2456) == 2500);
  CHECK(smooth_even_length(2401) == 2430);
  CHECK(smooth_even_length(15) == 16);
  CHECK(smooth_even_length(82) == 90);
}

// Protects the beam order (0 to starboard) and the sectors' half-open edges.
TEST_CASE("azimuths and sectors agree") {
  const Sonar sonar = p900();
  CHECK(beam_azimuth_rad(sonar, 0) == Approx(radians(-45 + 90.0 / 1024)));
  CHECK(beam_azimuth_rad(sonar, 511) == Approx(-beam_azimuth_rad(sonar, 0)));
  for (int j = 0; j < 512; ++j) {
    CHECK(sector_of(sonar, beam_azimuth_rad(sonar, j)) == j);
    CHECK(sector_of(sonar, beam_azimuth_rad(sonar, j) + 0.49 * sonar.beam_spacing_rad) == j);
  }
  CHECK_FALSE(sector_of(sonar, radians(45.001)));
  CHECK_FALSE(sector_of(sonar, radians(-45.001)));
  CHECK_FALSE(sector_of(sonar, std::nan("")));
}

TEST_CASE("levels and pressures") {
  CHECK(level_db(mean_square_pa2(152.04)) == Approx(152.04));
  CHECK(level_db(1e-12) == Approx(0).margin(1e-5));
  CHECK(level_db(0) == kNoEnergyDb);
  CHECK(level_db(1e-300) == kNoEnergyDb);
  CHECK(level_db(std::nan("")) == kNoEnergyDb);
  Sonar sonar = p900();
  sonar.source_level_db = 220;
  CHECK(source_pressure_pa_m(sonar) == Approx(1e5));
}
