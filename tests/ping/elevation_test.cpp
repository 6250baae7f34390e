// Echoes over elevation against closed forms, and against the expected power of a ping.
#include <algorithm>
#include <cmath>
#include <complex>

#include "acoustics/propagation.h"
#include "catch.h"
#include "core/units.h"
#include "labels/elevation.h"
#include "ping/ping_echoes.h"
#include "ping/tables.h"
#include "run_scene.h"
#include "synthesis/backend.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr const char* kElevationScene = R"(ensonify: 1
name: elevation
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 6
  beams: {count: 24, fov_deg: 24}
  rays: {elevation: 60, azimuth: 2, min_per_cell: 0}
  elevation: {fan_deg: 20}
materials:
  m: {reflectivity: 1e-3, law: {lambert: {exponent: 2}}}
  polished: {reflectivity: 1e-6, coherent: {model: kirchhoff, reflection: 0.9}}
output: {polar: false, cartesian: false, png: false, elevation: {step_deg: 0.25, volumes: true}}
)";
constexpr const char* kElevationFloor = R"(
objects:
  - {name: floor, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -0.5]}}
)";

// The sum of ping/tables.h, term by term: [beams x samples].
std::vector<double> power_by_terms(const std::vector<ElevationEcho>& echoes,
                                   const PowerSpread& spread, int beams, int samples) {
  const int period = static_cast<int>(spread.pulse.size());
  std::vector<std::complex<double>> coefficients(std::size_t(beams) * period);
  for (const ElevationEcho& echo : echoes) {
    const double turn = -2 * kPi * (double{echo.offset} + echo.sample) / period;
    for (int k = 0; k < period; ++k) {
      coefficients[std::size_t(echo.beam) * period + k] +=
          std::polar(double{echo.diffuse_pa2}, turn * k);
    }
  }
  std::vector<double> cells(std::size_t(beams) * samples);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (int k = 0; k < period; ++k) {
      const std::complex<double> a =
          coefficients[i / samples * period + k] * std::complex<double>(spread.pulse[k]);
      const double turn = 2 * kPi * k * static_cast<double>(i % samples) / period;
      cells[i] += (k == 0 ? 1 : 2) * (a * std::polar(1.0, turn)).real();
    }
  }
  std::vector<double> power(cells.size());
  for (int j = 0; j < beams; ++j) {
    for (int i = 0; i < beams; ++i) {
      for (int n = 0; n < samples; ++n) {
        power[std::size_t(j) * samples + n] +=
            double{spread.beam[std::size_t(j) * beams + i]} * cells[std::size_t(i) * samples + n];
      }
    }
  }
  return power;
}

// The largest difference from the reference backend's expected power, relative to its largest
// value, of the same echoes without their means.
double error_of(const std::string& text) {
  const SceneRun run = SceneRun::of_text(text);
  const Session& session = run.session();
  const Tracer tracer(session.world);
  const auto scattering = make_surface_scattering(session.sonar, session.water, session.world);
  const Fan fan = make_fan(session.sonar);
  const double step_rad = run.info().output.elevation_step_rad;
  PingEchoes echoes = ping_echoes(
      {session, fan, scattering, tracer, 0, sonar_pose(session, 0), false, 1, false, step_rad},
      Workers(2));
  for (Scatterer& s : echoes.scatterers.items) s.mean = 0;
  const auto backend = make_reference_backend({session.sonar, session.water, session.record, 1e-5});
  PingTask task;
  task.scatterers = &echoes.scatterers;
  task.volumes = echoes.volumes;
  PingSeries series;
  backend->synthesize({&task, 1}, {&series, 1}, Workers(2));
  const auto listed = elevation_echoes({echoes.scatterers, echoes.volume_elevation, session.sonar,
                                        source_pressure_pa_m(session.sonar), step_rad},
                                       Workers(2));
  REQUIRE(!listed.empty());
  const std::vector<double> power =
      power_by_terms(listed, power_spread(session.sonar, session.record), session.sonar.beam_count,
                     session.record.samples);
  double worst = 0, largest = 0;
  for (std::size_t i = 0; i < power.size(); ++i) {
    worst = std::max(worst, std::abs(power[i] - double{series.clean_power_pa2[i]}));
    largest = std::max(largest, double{series.clean_power_pa2[i]});
  }
  REQUIRE(largest > 0);
  return worst / largest;
}

}  // namespace

// Protects the promise of the list: pulse and beams applied to its sum over elevation give the
// expected power of surfaces and volumes. A wall across the beams has many echoes at one range.
TEST_CASE("pulse and beams make the expected power from echoes over elevation", "[figure]") {
  const std::string scene = std::string(kElevationScene) + kElevationFloor + R"(
  - {name: wall, material: m, shape: {box: {size_m: [0.2, 4, 4]}}, pose: {position_m: [4, 0, 0]}}
volumes: [{name: water, uniform: {strength_db: -50}}]
)";
  CHECK(error_of(scene) < 1e-4);
  std::string chirp = scene;
  chirp.insert(chirp.find("  beams:"), "  pulse: {lfm: {duration_s: 0.0005}}\n");
  CHECK(error_of(chirp) < 1e-4);
}

// Protects the elevation of every entry: a plane 0.5 m below is at -asin(0.5/r), with r from sample
// and offset.
TEST_CASE("echoes of a plane have the elevations of their ranges") {
  const SceneRun run = SceneRun::of_text(std::string(kElevationScene) + kElevationFloor);
  const PingResult ping = run.ping(0);
  const double step_m = range_step_m(run.info().sonar, run.info().water);
  const double step_rad = radians(0.25);
  REQUIRE(ping.elevation.size() > 24u * 60u / 4);
  for (const ElevationEcho& echo : ping.elevation) {
    const double range_m = (echo.sample + double{echo.offset}) * step_m;
    const double elevation = -std::asin(0.5 / range_m);
    CHECK(echo.step * step_rad <= elevation + 1e-6);
    CHECK((echo.step + 1) * step_rad >= elevation - 1e-6);
    CHECK(echo.instance == 1);
  }
}

// Protects the pressures of fixed amplitudes: a point target on the axis has S0 10^(TS/20) times
// the two-way loss at its own range, with the phase of the carrier, here 0.36 of
// a turn.
TEST_CASE("a point target has its pressure over elevation") {
  const SceneRun run = SceneRun::of_text(std::string(kElevationScene) + R"(
point_targets:
  - {name: t, position_m: [3.0003, 0, 0], target_strength_db: -20}
)");
  const PingResult ping = run.ping(0);
  REQUIRE(ping.elevation.size() == 1);
  const ElevationEcho& echo = ping.elevation[0];
  const Session& session = run.session();
  const double peak = source_pressure_pa_m(session.sonar) * 0.1 *
                      two_way_loss(3.0003, session.water.absorption_db_m);
  const double delay_s = 2 * 3.0003 / session.water.sound_speed_m_s;
  const std::complex<double> expected =
      std::polar(peak, -2 * kPi * carrier_turns(session.sonar.frequency_hz, delay_s));
  CHECK(std::abs(std::complex<double>(echo.coherent_pa) - expected) < 1e-5 * peak);
  CHECK(echo.diffuse_pa2 == 0);
  CHECK((echo.sample + double{echo.offset}) * range_step_m(session.sonar, session.water) ==
        Approx(3.0003).epsilon(1e-6));
}

// Protects glints, which are many pieces: the pressures of a polished sphere of radius a add up to
// those of its image, S0 R a/(2 d (d + a)) at the distance d of its surface, and the steps of
// elevation around its middle have most of their sum.
TEST_CASE("the pieces of a glint add up to its pressure, around the specular point") {
  const SceneRun run = SceneRun::of_text(std::string(kElevationScene) + R"(
objects:
  - name: ball
    material: polished
    shape: {sphere: {radius_m: 0.25}}
    pose: {position_m: [3, 0, 0]}
)");
  const PingResult ping = run.ping(0);
  std::complex<double> sum = 0, middle = 0;
  for (const ElevationEcho& echo : ping.elevation) {
    sum += std::complex<double>(echo.coherent_pa);
    if (echo.step >= -10 && echo.step < 10) middle += std::complex<double>(echo.coherent_pa);
  }
  const Session& session = run.session();
  const double peak = source_pressure_pa_m(session.sonar) * 0.9 * 0.25 / 2 * 2.75 / 3 *
                      two_way_loss(2.75, session.water.absorption_db_m);
  CHECK(ping.elevation.size() > 1000);
  CHECK(std::abs(sum) == Approx(peak).epsilon(0.01));
  CHECK(std::abs(middle) == Approx(peak).epsilon(0.05));
}
