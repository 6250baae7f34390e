#include <cmath>
#include <span>

#include "acoustics/pattern.h"
#include "catch.h"
#include "core/units.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

const std::string kProfiledWater =
    "ensonify: 1\nname: t\n"
    "sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 30,\n"
    "        beams: {count: 15, fov_deg: 15}, rays: {elevation: 24}}\n"
    "output: {cartesian: false, scatterers: true}\n";

struct Peak {
  double sample = 0, level_db = 0;
};

// The record between its samples: all of it, as it is band-limited.
Peak peak_of(std::span<const std::complex<float>> p) {
  const auto power_at = [&](double t) {
    std::complex<double> sum;
    for (std::size_t n = 0; n < p.size(); ++n) {
      const double u = kPi * (t - static_cast<double>(n));
      sum += std::complex<double>(p[n]) * (std::abs(u) < 1e-9 ? 1.0 : std::sin(u) / u);
    }
    return std::norm(sum);
  };
  std::size_t best = 0;
  for (std::size_t n = 0; n < p.size(); ++n) {
    if (std::norm(p[n]) > std::norm(p[best])) best = n;
  }
  const double middle = static_cast<double>(best);
  double low = middle - 1, high = middle + 1;
  for (int i = 0; i < 60; ++i) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (power_at(a) < power_at(b) ? low : high) = power_at(a) < power_at(b) ? a : b;
  }
  return {low, level_db(power_at(low))};
}

}  // namespace

// Protects range and level of what is heard through the whole chain, against the circle through
// sonar and target.
TEST_CASE("a target's echo stands at the travel time of its circle and at its level") {
  const double g = -1.5, x = 20, z = -2.5, source = 1500, c = source + g * z;
  const SceneRun run = SceneRun::of_text(
      kProfiledWater +
      "water: {sound_speed_m_s: 1480, absorption: {fixed_db_m: 0.2},\n"
      "        profile: {depth_m: [-100, 100], sound_speed_m_s: [1350, 1650]}}\n"
      "point_targets: [{name: p, target_strength_db: -30, position_m: [20, 0, -2.5]}]\n");
  const PingResult ping = run.ping(0);
  const Sonar& sonar = run.info().sonar;
  const int samples = run.info().record.samples;
  const Peak peak = peak_of(std::span(ping.series).subspan(7 * samples, samples));

  const double chord = std::hypot(x, z), bend = g * chord / (2 * source);
  // sin h = bend cos(phi), phi = elevation of the chord + h.
  const double h = std::atan(bend * (x / chord) / (1 + bend * z / chord));
  const double phi = std::asin(z / chord) + h;
  const double time = std::acosh(1 + g * g * chord * chord / (2 * source * c)) / std::abs(g);
  const double path = chord * h / std::sin(h), radius = x / std::cos(phi);
  CHECK(peak.sample == Approx(2 * time * sonar.bandwidth_hz).margin(1e-3));
  const double expected = sonar.source_level_db - 30 - 0.2 * 2 * path -
                          20 * std::log10(radius * radius * source / c) +
                          20 * std::log10(line_pattern(phi, sonar.elevation_width_rad));
  CHECK(peak.level_db == Approx(expected).margin(0.01));
  REQUIRE(ping.scatterers.size() == 1);
  CHECK(ping.scatterers.items[0].delay_s == Approx(2 * time).epsilon(1e-9));
  CHECK(ping.scatterers.items[0].departure.elevation_rad == Approx(phi).margin(1e-6));
  CHECK(length(ping.scatterers.items[0].position_m - Vec3{x, 0, z}) < 1e-9);
}

// Protects the instrument's range axis: it thinks in its own speed.
TEST_CASE("in faster water things look nearer") {
  const std::string ball =
      "materials: {m: {reflectivity: 1}}\n"
      "objects:\n"
      "  - {name: ball, material: m, shape: {sphere: {radius_m: 1}}, pose: {position_m: [11, 0, "
      "0]}}\n";
  const SceneRun fast = SceneRun::of_text(
      kProfiledWater + ball + "water: {profile: {depth_m: [0], sound_speed_m_s: [1560]}}\n");
  const SceneRun plain = SceneRun::of_text(kProfiledWater + ball);
  const float near = fast.ping(0).first_return_m[7], far = plain.ping(0).first_return_m[7];
  CHECK(far == Approx(10).margin(0.01));
  CHECK(near == Approx(far * 1500 / 1560).epsilon(1e-6));
}

// Protects every data set that gives its own speed as a profile: the same series, to the bit.
TEST_CASE("a profile of one speed, the instrument's, changes no byte") {
  const SceneRun plain("two_cylinders", {{"sonar.beams.count", "32"}});
  const SceneRun profiled("two_cylinders", {{"sonar.beams.count", "32"},
                                            {"water.profile.depth_m", "[0, 20]"},
                                            {"water.profile.sound_speed_m_s", "[1500, 1500]"}});
  REQUIRE(plain.session().water.sound_speed_m_s == 1500);
  const PingResult a = plain.ping(0), b = profiled.ping(0);
  CHECK(a.series == b.series);
  CHECK(a.polar->shadow == b.polar->shadow);
  CHECK(a.polar->instance == b.polar->instance);
}

// Protects the labels: shadows and amodal masks along bent rays, the same for any threads.
TEST_CASE("shadows and masks are made along bent rays") {
  const std::vector<Override> sea = {{"sonar.beams.count", "48"},
                                     {"sonar.rays.elevation", "60"},
                                     {"output.layers", "true"},
                                     {"water.profile.depth_m", "[-3, 0, 3, 10]"},
                                     {"water.profile.sound_speed_m_s", "[1520, 1505, 1495, 1490]"}};
  const SceneRun run("sonar_tank", sea);
  const PingResult one = run.ping(0, 1), two = run.ping(0, 2);
  CHECK(one.series == two.series);
  CHECK(one.polar->shadow == two.polar->shadow);
  // Much as in water of one speed: what stands before the wall is the same.
  const SceneRun plain("sonar_tank", {sea.begin(), sea.begin() + 2});
  const PingResult straight = plain.ping(0);
  const auto in_shadow = [](const PingResult& ping) {
    return static_cast<double>(std::count(ping.polar->shadow.begin(), ping.polar->shadow.end(), 2));
  };
  REQUIRE(in_shadow(straight) > 10);
  CHECK(in_shadow(one) == Approx(in_shadow(straight)).epsilon(0.4));
  CHECK(one.series != straight.series);
  const auto cylinder = std::find_if(one.polar_annotations.begin(), one.polar_annotations.end(),
                                     [](const Annotation& a) { return a.instance == 2; });
  REQUIRE(cylinder != one.polar_annotations.end());
  CHECK(cylinder->amodal);
}
