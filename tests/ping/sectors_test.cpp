// Sectors of beams with frequencies of their own, and bands of a detector.
#include <cmath>
#include <complex>
#include <string>
#include <vector>

#include "acoustics/propagation.h"
#include "catch.h"
#include "core/units.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

std::string scene(const std::string& keys, const std::string& things) {
  return R"(ensonify: 1
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  pulse: flat
  range_max_m: 12
  beams: {count: 32, fov_deg: 64, receive_width_deg: 1}
  rays: {elevation: 8, min_per_cell: 0}
)" + keys +
         R"(water: {sound_speed_m_s: 1500, absorption: {model: francois_garrison, temperature_c: 12}}
output: {cartesian: false, png: false, shadow: false, amodal: false}
trajectory: {poses: [{time_s: 0}], ping_rate_hz: 1}
)" + things;
}

}  // namespace

TEST_CASE("each sector has the absorption and the width of its frequency") {
  const std::string targets =
      "point_targets:\n"
      "  - {name: a, target_strength_db: -20, position_m: [8, -0.1396255, 0]}\n"
      "  - {name: b, target_strength_db: -20, position_m: [9, 0.1570788, 0]}\n";
  const SceneRun plain = SceneRun::of_text(scene("", targets));
  const SceneRun run = SceneRun::of_text(
      scene("  transmit: {sectors: [16, 16], frequency_hz: [8e5, 1e6], interval_s: 0}\n", targets));
  const Sonar& sonar = run.session().sonar;
  CHECK(sonar.width_rad.front() == Approx(radians(1) * 9 / 8));
  CHECK(sonar.width_rad.back() == Approx(radians(1) * 0.9));
  CHECK(plain.session().sonar.width_rad.empty());
  const PingResult before = plain.ping(0), after = run.ping(0);
  REQUIRE(before.scatterers.size() == 2);
  REQUIRE(after.scatterers.size() == 2);
  const SeaWater water{12, 35, 8, 0};
  for (std::size_t i = 0; i < 2; ++i) {
    const Scatterer &s = before.scatterers.items[i], &t = after.scatterers.items[i];
    REQUIRE(s.beam == 15 + i);
    const double carrier_hz = i == 0 ? 8e5 : 1e6;
    const double more_db_m =
        francois_garrison_db_m(carrier_hz, water) - francois_garrison_db_m(9e5, water);
    const double expected = std::pow(10.0, -more_db_m * 1500 * s.delay_s / 20);
    REQUIRE(std::abs(expected - 1) > 0.01);
    CHECK(double{t.gain} / double{s.gain} == Approx(expected).epsilon(1e-5));
    // On the axis of its beam.
    const std::size_t samples = after.series.size() / 32;
    const auto at = s.beam * samples + static_cast<std::size_t>(std::lround(29900 * s.delay_s));
    CHECK(std::abs(std::complex<double>(after.series[at]) /
                   std::complex<double>(before.series[at])) == Approx(expected).epsilon(0.02));
  }
}

TEST_CASE("sectors that move fire from their own poses, in turn") {
  const SceneRun run = SceneRun::of_text(
      scene("  transmit: {sectors: [8, 24], turnaround_s: 0.004, frequency_hz: [8e5, 1e6]}\n",
            "motion_within_ping: true\nmaterials: {m: {reflectivity: 1e-3}}\n"
            "objects: [{name: wall, material: m, shape: {box: {size_m: [1, 40, 40]}}, trajectory: "
            "{poses: [{time_s: 0, position_m: [5.5, 0, 0]}, {time_s: 1, position_m: [4.5, 0, "
            "0]}]}}]\n"));
  const double interval_s = 2 * 12.0 / 1500 + 0.004;
  CHECK(run.session().sonar.transmit->interval_s == Approx(interval_s));
  std::vector<int> heard(2);
  for (const Scatterer& s : run.ping(0).scatterers.items) {
    const int sector = s.beam < 8 ? 0 : 1;
    ++heard[sector];
    const double range_m = (5 - interval_s * sector) / (std::cos(double{s.arrival.elevation_rad}) *
                                                        std::cos(double{s.arrival.azimuth_rad}));
    REQUIRE(s.delay_s == Approx(2 * range_m / 1501).epsilon(3e-4));
  }
  CHECK(heard == std::vector{8 * 8, 24 * 8});
}

// Protects that bands are independent, and noise as well as echoes: two looks at uncorrelated
// samples.
TEST_CASE("two bands of a detector give speckle two looks and leave its samples uncorrelated") {
  const bool is_noise = GENERATE(false, true);
  CAPTURE(is_noise);
  const SceneRun run = SceneRun::of_text(scene(
      "  detector: {bands: 2}\n", is_noise
                                      ? "noise: {spectrum_level_db: 60}\npoint_targets: [{name: "
                                        "t, target_strength_db: -90, position_m: [3, 0, 0]}]\n"
                                      : "volumes: [{name: water, uniform: {strength_db: -40}}]\n"));
  const PingResult ping = run.ping(0);
  const std::size_t samples = ping.series.size() / 32;
  double sum = 0, square = 0, lagged = 0, count = 0;
  const auto level_db = [&](std::size_t n, std::size_t beam) {
    const double clean_db = is_noise ? 0 : double{ping.polar->clean_db[n * 32 + beam]};
    return double{ping.polar->level_db[n * 32 + beam]} - clean_db;
  };
  for (std::size_t beam = 0; beam < 32; beam += 2) {
    for (std::size_t n = 100; n + 50 < samples; ++n) {
      const double x = level_db(n, beam);
      sum += x;
      square += x * x;
      lagged += x * level_db(n + 1, beam);
      ++count;
    }
  }
  const double mean = sum / count, variance = square / count - mean * mean;
  CHECK(std::sqrt(variance) == Approx(3.49).epsilon(4 * 0.9 / std::sqrt(count)));
  if (!is_noise) CHECK(mean == Approx(-1.17).margin(4 * 3.49 / std::sqrt(count)));
  CHECK((lagged / count - mean * mean) / variance == Approx(0).margin(4.5 / std::sqrt(count)));
}
