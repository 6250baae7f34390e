// Elastic bodies as point targets and objects, through the whole chain.
#include "ping/ringing.h"

#include <cmath>
#include <complex>

#include "acoustics/elastic_body.h"
#include "catch.h"
#include "core/units.h"
#include "ping/ping_echoes.h"
#include "ping/scene_warnings.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

const std::string kRinging = R"(ensonify: 1
sonar:
  frequency_hz: 200000
  bandwidth_hz: 40000
  source_level_db: 220
  range_max_m: 8
  beams: {count: 16, spacing_deg: 1, receive_width_deg: 1}
  elevation: {width_deg: 20}
  rays: {elevation: 8, azimuth: 1, min_per_cell: 0}
water: {sound_speed_m_s: 1500, density_kg_m3: 1000, absorption: {fixed_db_m: 0}}
output: {cartesian: false, png: false}
)";
const std::string kRingingBall =
    "point_targets:\n  - {name: ball, sphere: {radius_m: 0.01905, material: tungsten_carbide}, "
    "position_m: [4, 0.035, 0]}\n";

}  // namespace

TEST_CASE("a sphere echoes by its taps") {
  const SceneRun run = SceneRun::of_text(kRinging + kRingingBall);
  const PointTarget& target = run.session().world.point_targets[0];
  const PingResult ping = run.ping(0);
  REQUIRE(target.ringing.taps.size() > 3);
  REQUIRE(ping.scatterers.size() == target.ringing.taps.size());
  const double center_s = 2 * std::hypot(4, 0.035) / 1500;
  std::complex<double> sum = 0;
  for (std::size_t i = 0; i < target.ringing.taps.size(); ++i) {
    const Scatterer& s = ping.scatterers.items[i];
    CHECK(s.delay_s == Approx(center_s + target.ringing.taps[i].delay_s).epsilon(1e-12));
    CHECK(s.instance == 1);
    CHECK(s.position_m.x == Approx(4));
    if (i > 0) CHECK(s.key != ping.scatterers.items[i - 1].key);
    sum +=
        std::complex<double>(s.mean) * std::polar(1.0, -2 * kPi * 200e3 * (s.delay_s - center_s));
  }
  const ElasticBody sphere{0.01905, kTungstenCarbide, 0.01905};
  const std::complex<double> wanted = sphere_backscatter_m(sphere, run.session().water, 200e3);
  CHECK(run.session().water.density_kg_m3 == 1000);
  CHECK(std::abs(sum - wanted) < 0.06 * std::abs(wanted));
  CHECK(run.session().world.instances[0].target_strength_db ==
        Approx(20 * std::log10(std::abs(wanted))));
  CHECK(scene_warnings(run.session()).empty());
}

TEST_CASE("ringing is part of the target's mask, and a wall hides all of it") {
  const SceneRun heard = SceneRun::of_text(kRinging + kRingingBall);
  const SceneRun once = SceneRun::of_text(
      kRinging +
      "point_targets: [{name: p, target_strength_db: -40, position_m: [4, 0.035, 0]}]\n");
  const auto pixels = [](const SceneRun& run) {
    const PingResult ping = run.ping(0);
    const auto& ids = ping.polar->instance;
    return std::count(ids.begin(), ids.end(), std::uint16_t{1});
  };
  CHECK(pixels(heard) > pixels(once));
  const SceneRun hidden = SceneRun::of_text(
      kRinging + kRingingBall +
      "materials: {m: {reflectivity: 0}}\n"
      "objects: [{name: wall, material: m, shape: {box: {size_m: [0.1, 4, 4]}}, pose: {position_m: "
      "[2, 0, 0]}}]\n");
  for (const Scatterer& s : hidden.ping(0).scatterers.items) CHECK(s.instance != 2);
}

// Motion computes delays anew; taps keep theirs.
TEST_CASE("a sphere rings in the same manner for a sonar that moves") {
  const std::string ways =
      "trajectory: {poses: [{time_s: 0}, {time_s: 1, position_m: [1, 0, 0]}], ping_rate_hz: 1, "
      "pings: 1}\n";
  for (const std::string& more :
       {std::string(), std::string("multipath: {surface: {z_m: 0.2, reflection: -1}}\n")}) {
    const SceneRun rest = SceneRun::of_text(kRinging + kRingingBall + ways + more);
    const SceneRun moved =
        SceneRun::of_text(kRinging + kRingingBall + ways + more + "motion_within_ping: true\n");
    const auto &a = rest.ping(0).scatterers.items, &b = moved.ping(0).scatterers.items;
    const std::size_t taps = rest.session().world.point_targets[0].ringing.taps.size();
    REQUIRE(a.size() >= taps);
    for (const std::uint16_t path : {0, 1}) {
      std::vector<double> still, shifted;
      for (const Scatterer& s : a) {
        if (s.path == path) still.push_back(s.delay_s);
      }
      for (const Scatterer& s : b) {
        if (s.path == path) shifted.push_back(s.delay_s);
      }
      if (more.empty() && path == 1) continue;
      REQUIRE(still.size() == taps);
      REQUIRE(shifted.size() == taps);
      for (std::size_t i = 1; i < taps; ++i) {
        CHECK(shifted[i] - shifted[0] == Approx(still[i] - still[0]).margin(1e-9));
      }
      CHECK(shifted[0] < still[0]);
    }
  }
}

// The object hides what is behind it and has a mask; its echo is that of the target.
TEST_CASE("an elastic sphere echoes as an object as it does as a target") {
  const SceneRun target = SceneRun::of_text(kRinging + kRingingBall);
  const SceneRun object = SceneRun::of_text(
      kRinging +
      "materials: {m: {reflectivity: 0}}\n"
      "objects: [{name: ball, material: m, shape: {sphere: {radius_m: 0.01905}}, elastic: "
      "{material: tungsten_carbide}, pose: {position_m: [4, 0.035, 0]}}]\n");
  const auto &a = target.ping(0).series, &b = object.ping(0).series;
  REQUIRE(a.size() == b.size());
  double difference = 0, all = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference += std::norm(a[i] - b[i]);
    all += std::norm(a[i]);
  }
  CHECK(difference < 1e-10 * all);
  REQUIRE(object.session().world.instances[0].elastic);
  CHECK(object.session().world.instances[0].elastic->material == kTungstenCarbide);
}

TEST_CASE("an elastic cylinder has the echo of its length") {
  const SceneRun run = SceneRun::of_text(
      kRinging +
      "materials: {m: {reflectivity: 0}}\n"
      "objects: [{name: rod, material: m, shape: {cylinder: {radius_m: 0.02, height_m: 0.1}}, "
      "elastic: {material: aluminum}, pose: {position_m: [4, 0.035, 0]}}]\n");
  const auto scatterers = run.ping(0).scatterers.items;
  const double center_s = 2 * std::hypot(4, 0.035) / 1500;
  std::complex<double> sum = 0;
  for (const Scatterer& s : scatterers) {
    sum +=
        std::complex<double>(s.mean) * std::polar(1.0, -2 * kPi * 200e3 * (s.delay_s - center_s));
  }
  // So short that it lies in one Fresnel zone: k l^2/(4 r) = 0.5.
  const std::complex<double> wanted =
      0.1 * cylinder_backscatter({0.02, kAluminum, 0.02}, run.session().water, 200e3);
  CHECK(std::abs(sum) == Approx(std::abs(wanted)).epsilon(0.08));
}

TEST_CASE("check warns of a sphere with too many resonances") {
  const SceneRun run = SceneRun::of_text(
      kRinging +
      "point_targets: [{name: drum, sphere: {radius_m: 0.3, material: steel, wall_m: 0.004, "
      "filling: water}, position_m: [4, 0, 0]}]\n");
  const auto warnings = scene_warnings(run.session());
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].find("drum: the body has so many resonances") == 0);
}
