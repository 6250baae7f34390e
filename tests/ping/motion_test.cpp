// motion_within_ping through the whole chain.
#include "ping/ping_echoes.h"
#include "ping/prepare_session.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>

#include "catch.h"
#include "core/units.h"
#include "results.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

using Complex = std::complex<double>;

const std::string kSonar = R"(ensonify: 1
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 8
  beams: {count: 32, fov_deg: 32}
  rays: {elevation: 8}
water: {sound_speed_m_s: 1500, absorption: {fixed_db_m: 0}}
output: {cartesian: false, png: false, shadow: false, amodal: false}
)";
const std::string kTarget =
    "point_targets: [{name: p, target_strength_db: -20, position_m: [6, 0.05, 0]}]\n";
const std::string kBurst = "synthesis: {tolerance: 1e-4}\n";

std::string on(bool key) { return key ? "motion_within_ping: true\n" : ""; }

// Straight on for a second from the origin.
std::string ahead(double speed_m_s, double ping_rate_hz, int pings, double yaw_deg = 0) {
  return "trajectory: {poses: [{time_s: 0}, {time_s: 1, position_m: [" + std::to_string(speed_m_s) +
         ", 0, 0], rotation_deg: [0, 0, " + std::to_string(yaw_deg) +
         "]}], ping_rate_hz: " + std::to_string(ping_rate_hz) +
         ", pings: " + std::to_string(pings) + "}\n";
}

SceneRun with_burst(const std::string& text) {
  std::string burst = text;
  burst.replace(burst.find("range_max_m: 8"), 14,
                "range_max_m: 16\n  pulse: {cw: {duration_s: 0.01}}");
  return SceneRun::of_text(burst);
}

// The strongest sample.
std::size_t peak_of(const Series& p) {
  return static_cast<std::size_t>(
      std::max_element(p.begin(), p.end(),
                       [](auto a, auto b) { return std::norm(a) < std::norm(b); }) -
      p.begin());
}

// Of the middle of a burst of 10 ms from range r, in the beam that hears most, by the slope of its
// phase.
double shift_hz(const SceneRun& run, const Series& p, double range_m) {
  const int samples = run.session().record.samples;
  const double b = run.session().sonar.bandwidth_hz;
  const std::size_t row = peak_of(p) / samples * samples;
  const int middle = static_cast<int>(2 * range_m / 1500 * b);
  Complex turn = 0;
  for (int n = middle - 100; n < middle + 100; ++n) {
    turn += Complex(p[row + n + 1]) * std::conj(Complex(p[row + n]));
  }
  return std::arg(turn) / (2 * kPi) * b;
}

}  // namespace

// Closing by 0.19 wavelengths from ping to ping turns the echo by 4 pi 0.19.
TEST_CASE("the phase from ping to ping is 4 pi v T / lambda") {
  const bool key = GENERATE(false, true);
  const double speed = GENERATE(0.025, -0.025);
  const SceneRun run = SceneRun::of_text(kSonar + kTarget + on(key) + ahead(speed, 80, 3));
  const auto first = run.ping(0).series, second = run.ping(1).series;
  const std::size_t peak = peak_of(first);
  const double turned = std::arg(Complex(second[peak]) * std::conj(Complex(first[peak])));
  CHECK(turned == Approx(4 * kPi * speed * 0.0125 * 900e3 / 1500).epsilon(0.01));
}

TEST_CASE("a burst of 10 ms from a moving sonar is shifted by 2 v f / c") {
  const double speed = GENERATE(1.5, -0.8);
  const std::string scene = kSonar + kTarget + kBurst + ahead(speed, 1, 1);
  const SceneRun moving = with_burst(scene + on(true));
  CHECK(shift_hz(moving, moving.ping(0).series, 6) ==
        Approx(2 * speed * 900e3 / 1500).epsilon(0.01));
  const SceneRun still = with_burst(scene);
  CHECK(std::abs(shift_hz(still, still.ping(0).series, 6)) < 1);
}

TEST_CASE("a burst of 10 ms from a moving object is shifted by 2 v f / c") {
  const SceneRun run = with_burst(
      kSonar + kBurst + on(true) +
      "materials: {m: {reflectivity: 1e-2}}\n"
      "objects: [{name: ball, material: m, shape: {sphere: {radius_m: 0.3}}, trajectory: {poses: "
      "[{time_s: 0, position_m: [6.3, 0, 0]}, {time_s: 1, position_m: [5.1, 0, 0]}]}}]\n");
  const PingResult ping = run.ping(0);
  CHECK(shift_hz(run, ping.series, 6) == Approx(2 * 1.2 * 900e3 / 1500).epsilon(0.01));
  for (const Scatterer& s : ping.scatterers.items) {
    REQUIRE(s.doppler == Approx(2 * 1.2 / 1500).epsilon(0.02));
  }
}

// 320 degrees a second for 9.3 ms are three sectors.
TEST_CASE("a sonar that turns hears a target in another beam") {
  const std::string scene =
      kSonar +
      "point_targets: [{name: p, target_strength_db: -20, position_m: [7, 0.183, 0]}]\n"
      "trajectory: {poses: [{time_s: 0}, {time_s: 0.5, rotation_deg: [0, 0, 160]}]}\n";
  const auto strongest = [](const SceneRun& run) {
    const PingResult ping = run.ping(0);
    REQUIRE(ping.scatterers.size() == 1);
    const auto beam = peak_of(ping.series) / run.session().record.samples;
    CHECK(beam == ping.scatterers.items[0].beam);
    return static_cast<int>(beam);
  };
  const int still = strongest(SceneRun::of_text(scene));
  const int turning = strongest(SceneRun::of_text(scene + on(true)));
  CHECK(still - turning == 3);
}

// Protects scenes without motion, whose bytes must not depend on the key.
TEST_CASE("where nothing moves the key changes nothing") {
  const std::string scene = kSonar + kTarget +
                            "materials: {m: {reflectivity: 1e-3}}\n"
                            "objects: [{name: room, material: m, shape: {box: {size_m: [14, 9, 4], "
                            "inward_facing: true}}}]\n"
                            "noise: {spectrum_level_db: 40}\n";
  const SceneRun off = SceneRun::of_text(scene), with = SceneRun::of_text(scene + on(true));
  CHECK_FALSE(moves(with.session()));
  CHECK(doppler_range(with.session()).highest == 0);
  CHECK(off.ping(0).series == with.ping(0).series);
  CHECK(off.ping(0).polar->clean_db == with.ping(0).polar->clean_db);
  // A way of which this ping sees nothing: its end is reached, from there the sonar rests.
  const SceneRun ended = SceneRun::of_text(scene + on(true) +
                                           "trajectory: {poses: [{time_s: 0, position_m: [-1, 0, "
                                           "0]}, {time_s: 1}], ping_rate_hz: 1, pings: 2}\n");
  CHECK(moves(ended.session()));
  const PingResult last = ended.ping(1), whole = with.ping(0);
  REQUIRE(last.scatterers.size() == whole.scatterers.size());
  for (std::size_t i = 0; i < whole.scatterers.size(); ++i) {
    REQUIRE(last.scatterers.items[i].delay_s == whole.scatterers.items[i].delay_s);
    REQUIRE(last.scatterers.items[i].doppler == 0);
  }
  CHECK(ended.ping(0).scatterers.items[0].doppler != 0);
}

// Everything at once: a mirror and a wall, fish, shadows with their occluders, layers, noise, wave
// motion; the same with any number of threads, and layers that add up.
TEST_CASE("a moving scene with all that a ping can hold") {
  std::string scene = kSonar + on(true) + R"(materials:
  wall: {reflectivity: 1e-3}
  mirror: {reflectivity: 1e-2, coherent: {model: kirchhoff, reflection: 0.8, roughness_rms_m: 1e-4}}
objects:
  - {name: room, material: wall, shape: {box: {size_m: [12, 10, 4], inward_facing: true}}}
  - {name: ball, material: mirror, shape: {sphere: {radius_m: 0.2}}, trajectory: {poses: [{time_s: 0, position_m: [2.5, 0.3, 0]}, {time_s: 1, position_m: [1.5, -0.4, 0.2], rotation_deg: [0, 50, 0]}]}}
point_targets: [{name: tip, target_strength_db: -30, position_m: [3, -0.5, 0]}]
volumes:
  - {name: herring, pose: {position_m: [3.5, 0.5, 0]}, school: {size_m: [1, 1, 1], fish: 40, target_strength_db: -40}}
trajectory: {poses: [{time_s: 0}, {time_s: 1, position_m: [1.5, 0.5, 0]}], ping_rate_hz: 4, pings: 2, wave_motion: {yaw_deg: 2, roll_deg: 3, period_s: 1}}
noise: {spectrum_level_db: 40}
)";
  scene.replace(scene.find("shadow: false, amodal: false"), 28, "layers: true, scatterers: true");
  scene.replace(scene.find("count: 32, fov_deg: 32"), 22, "count: 16, fov_deg: 16");
  const SceneRun run = SceneRun::of_text(scene);
  const PingResult one = run.ping(1, 1), three = run.ping(1, 3);
  CHECK(one.series == three.series);
  CHECK(one.polar->clean_db == three.polar->clean_db);
  CHECK(one.polar->shadow == three.polar->shadow);
  std::vector<Complex> left(one.series.begin(), one.series.end());
  double error = 0, norm = 0;
  for (const LayerSeries& layer : one.layers) {
    for (std::size_t i = 0; i < left.size(); ++i) left[i] -= Complex(layer.pressure_pa[i]);
  }
  for (std::size_t i = 0; i < left.size(); ++i) {
    error += std::norm(left[i]);
    norm += std::norm(Complex(one.series[i]));
  }
  CHECK(std::sqrt(error / norm) < 1e-7);
  // By the ball's own velocity towards the sonar, as the scene says it: about 1 m/s and 1.5 m/s.
  double ball = 0;
  int count = 0;
  for (const Scatterer& s : one.scatterers.items) {
    if (s.instance != 2) continue;
    ball += static_cast<double>(s.doppler);
    ++count;
  }
  REQUIRE(count > 10);
  CHECK(ball / count == Approx(2 * 2.5 / 1500).epsilon(0.15));
  CHECK(std::accumulate(one.polar->shadow.begin(), one.polar->shadow.end(), 0) > 0);
}

// Protects the backend that judges from being fed otherwise.
TEST_CASE("a moving ping is the reference's") {
  const SceneRun run = SceneRun::of_text(kSonar + kTarget + on(true) + ahead(2, 1, 1, 20));
  const PingResult ping = run.ping(0);
  const auto reference =
      make_reference_backend({run.session().sonar, run.session().water, run.session().record});
  const PingTask task{&ping.scatterers, {}, 0, {}, false};
  PingSeries expected;
  reference->synthesize({&task, 1}, {&expected, 1}, Workers(2));
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < expected.pressure_pa.size(); ++i) {
    error += std::norm(ping.series[i] - expected.pressure_pa[i]);
    norm += std::norm(expected.pressure_pa[i]);
  }
  CHECK(std::sqrt(error / norm) < 1e-5);
  CHECK(ping.scatterers.items[0].doppler == Approx(4.0 / 1500).epsilon(0.01));
  const DopplerRange range = doppler_range(run.session());
  CHECK(range.highest > 4.0 / 1500);
  CHECK(range.highest < 4.2 / 1500);
  CHECK(range.lowest < 4 * std::cos(radians(16)) / 1500);
  CHECK(range.lowest > 3.4 / 1500);
}

TEST_CASE("a measured pulse with steps cannot be shifted, and the message says so") {
  const TemporaryFolder folder;
  folder.write("pulse.csv",
               "frequency_hz,amplitude,phase_deg\n890000,0.5,0\n900000,1,10\n910000,0.7,0\n");
  std::string text = kSonar + kTarget + on(true);
  text.replace(text.find("range_max_m: 8"), 14,
               "range_max_m: 8\n  pulse: {table: {file: pulse.csv}}");
  auto scenario = value_of(load_scenario(folder.write("scene.yaml", text)));
  check_fails(prepare_session(std::move(scenario), 0), ErrorKind::usage, {"motion_within_ping: "});
}
