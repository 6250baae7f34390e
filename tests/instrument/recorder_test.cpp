// Counts, gains and what a reader makes of them.
#include "instrument/recorder.h"

#include <cmath>
#include <vector>

#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

// [rows x 4], from row to row and column to column.
std::vector<float> levels(int rows, double first_db, double row_db, double column_db) {
  std::vector<float> level_db;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < 4; ++column) {
      level_db.push_back(float(first_db + row * row_db + column * column_db));
    }
  }
  return level_db;
}

}  // namespace

TEST_CASE("counts in dB stand for their level to half a step") {
  Recorder recorder;
  recorder.db = {60, 140};
  const auto level_db = levels(20, 55, 4.4, 0.13);
  const RecordedPing ping = record_ping(recorder, level_db, 4, 0.1, 0);
  REQUIRE(ping.counts_8.size() == level_db.size());
  CHECK(ping.counts_16.empty());
  CHECK(ping.row_gain.empty());
  for (std::size_t i = 0; i < level_db.size(); ++i) {
    const double shown = recorded_level_db(recorder, ping.counts_8[i], 1);
    const double expected = std::clamp(double(level_db[i]), 60.0, 140.0);
    CHECK(std::abs(shown - expected) <= 40.0 / 255 + 1e-9);
  }
}

TEST_CASE("counts of the amplitude are a power of it, and no echo is 0") {
  Recorder recorder{.bits = 16, .scale = GreyScale::amplitude, .db = {0, 140}, .gamma = 0.7};
  std::vector<float> level_db = {140, 120, 100, kNoEnergyDb};
  const RecordedPing ping = record_ping(recorder, level_db, 4, 0.1, 0);
  CHECK(ping.counts_16[0] == 65535);
  CHECK(ping.counts_16[1] == std::round(65535 * std::pow(0.1, 0.7)));
  CHECK(ping.counts_16[3] == 0);
  CHECK(recorded_level_db(recorder, ping.counts_16[2], 1) == Approx(100).margin(0.01));
  CHECK(recorded_level_db(recorder, 0, 1) == kNoEnergyDb);
}

TEST_CASE("the row gain brings weak rows to full scale, and dividing by it restores the level") {
  Recorder recorder{.bits = 16, .scale = GreyScale::amplitude, .db = {0, 140}, .row_gain_db = 30};
  const auto level_db = levels(3, 130, -25, 1);  // peaks 133, 108, 83 dB
  const RecordedPing ping = record_ping(recorder, level_db, 4, 0.1, 0);
  REQUIRE(ping.row_gain.size() == 3);
  CHECK(10 * std::log10(ping.row_gain[0]) == Approx(7).margin(1e-4));
  CHECK(10 * std::log10(ping.row_gain[1]) == Approx(30).margin(1e-4));
  CHECK(10 * std::log10(ping.row_gain[2]) == Approx(30).margin(1e-4));
  CHECK(ping.counts_16[3] == 65535);
  for (std::size_t i = 0; i < level_db.size(); ++i) {
    CHECK(recorded_level_db(recorder, ping.counts_16[i], ping.row_gain[i / 4]) ==
          Approx(level_db[i]).margin(0.1));
  }
}

TEST_CASE("amplitudes of counts are relative to full scale, and none without an echo") {
  const Recorder db{.bits = 8, .db = {60, 140}};
  CHECK(recorded_amplitude(db, 255, 1) == Approx(1));
  CHECK(recorded_amplitude(db, 0, 1) == Approx(1e-4));
  const Recorder power{.bits = 16, .scale = GreyScale::amplitude, .db = {0, 600}, .gamma = 0.5};
  CHECK(recorded_amplitude(power, 65535, 1) == Approx(1));
  CHECK(recorded_amplitude(power, 6553.5, 1) == Approx(0.01));
  CHECK(recorded_amplitude(power, 65535, 4) == Approx(0.5));
  CHECK(recorded_amplitude(power, 0, 1) == 0);
  CHECK(recorded_amplitude(power, 65535, 0) == 0);
}

TEST_CASE("the time-varied gain rises with range in steps") {
  Recorder recorder{.bits = 16, .db = {0, 200}, .spreading = 30, .absorption = true, .step_db = 3};
  const std::vector<float> level_db(4 * 200, 80);
  const RecordedPing ping = record_ping(recorder, level_db, 4, 0.5, 0.05);
  for (const int row : {1, 2, 20, 199}) {
    const double range_m = 0.5 * row;
    const double gain_db = 3 * std::round((30 * std::log10(range_m) + 0.1 * range_m) / 3);
    CHECK(recorded_level_db(recorder, ping.counts_16[4 * row], 1) ==
          Approx(80 + gain_db).margin(0.01));
  }
  CHECK(ping.counts_16[0] == ping.counts_16[4]);
}

TEST_CASE("the automatic gain levels the record and is low behind a strong row") {
  Recorder recorder{.bits = 16, .db = {0, 200}};
  recorder.range_gain = RangeGain{100, 0.2, 2, 60};
  std::vector<float> level_db(4 * 400, 70);
  for (int column = 0; column < 4; ++column) level_db[4 * 200 + column] = 110;
  const RecordedPing ping = record_ping(recorder, level_db, 4, 0.1, 0);
  const auto shown = [&](int row) { return recorded_level_db(recorder, ping.counts_16[4 * row], 1); };
  CHECK(shown(199) == Approx(100).margin(0.01));
  // One row raises the smoothed power to (1 - exp(-0.5)) of its own; then it falls by e in 2 m.
  const double share = 1 - std::exp(-0.5);
  CHECK(shown(200) == Approx(100 - 10 * std::log10(share)).margin(0.01));
  const double rest = share * std::pow(10.0, 4) * std::exp(-50 * 0.1 / 2) + 1;
  CHECK(shown(250) == Approx(100 - 10 * std::log10(rest)).margin(0.05));
  recorder.range_gain->max_gain_db = 10;
  CHECK(recorded_level_db(recorder, record_ping(recorder, level_db, 4, 0.1, 0).counts_16[400], 1) ==
        Approx(80).margin(0.01));
}
