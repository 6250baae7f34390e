// The paper's tank, through the whole chain: geometry, shadow, masks and levels of its figures.
#include <cmath>
#include <functional>

#include "catch.h"
#include "core/units.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

struct Tank {
  SceneRun run{"sonar_tank", {{"trajectory.pings", "1"}}};
  PingResult ping = run.ping(0);
  const Sonar& sonar = run.session().sonar;
  const LabelledImage& polar = *ping.polar;

  double range_m(int n) const { return sample_range_m(sonar, run.session().water, n); }
  double azimuth_deg(int j) const { return degrees(beam_azimuth_rad(sonar, j)); }
  float clean_db(int n, int j) const { return polar.clean_db[std::size_t(n) * polar.columns + j]; }
  int instance(int n, int j) const { return polar.instance[std::size_t(n) * polar.columns + j]; }

  // The first sample within 6 dB of a beam's maximum.
  int onset(int j) const {
    float most = kNoEnergyDb;
    for (int n = 0; n < polar.rows; ++n) most = std::max(most, clean_db(n, j));
    int n = 0;
    while (clean_db(n, j) < most - 6) ++n;
    return n;
  }
};

}  // namespace

// V16 and the reach beyond it: the wall within one sample of 5.5/cos(theta) for 5 < |theta| < 15
// degrees, within four out to 40; the cylinder from 3.80 m on the centre beams.
TEST_CASE("V16: wall and cylinder stand where they should") {
  const Tank tank;
  const double step_m = tank.range_m(1);
  int judged = 0;
  for (int j = 0; j < 512; ++j) {
    const double azimuth = std::abs(tank.azimuth_deg(j));
    if (azimuth < 5 || azimuth > 40) continue;
    const double wall_m = 5.5 / std::cos(radians(azimuth));
    const double allowed = azimuth < 15 ? 1.0 : 4.0;
    INFO("beam " << j << " at " << tank.azimuth_deg(j) << " deg");
    CHECK(std::abs(tank.range_m(tank.onset(j)) - wall_m) <= allowed * step_m);
    ++judged;
  }
  CHECK(judged > 350);
  CHECK(tank.range_m(tank.onset(255)) == Approx(3.80).margin(step_m));
  CHECK(tank.range_m(tank.onset(256)) == Approx(3.80).margin(step_m));
}

// Protects the shadow: as deep as the pattern's side lobes let it be, 14.2 dB.
TEST_CASE("the cylinder casts its shadow on the wall") {
  const Tank tank;
  const auto mean_power = [&](const std::function<bool(double)>& chosen) {
    double sum = 0;
    int count = 0;
    for (int j = 0; j < 512; ++j) {
      if (!chosen(std::abs(tank.azimuth_deg(j)))) continue;
      for (int n = 0; n < tank.polar.rows; ++n) {
        if (!(tank.range_m(n) > 5.3 && tank.range_m(n) < 6.0)) continue;
        sum += mean_square_pa2(tank.clean_db(n, j));
        ++count;
      }
    }
    return sum / count;
  };
  const double shadow = mean_power([](double a) { return a < 1; });
  const double lit = mean_power([](double a) { return a > 6 && a < 10; });
  CHECK(10 * std::log10(lit / shadow) == Approx(14.2).margin(1));
}

// Protects the masks: the cylinder only where rays can meet its near side, the wall where they
// cannot, nothing between the two.
TEST_CASE("masks fit the tank") {
  const Tank tank;
  const double half_width_deg = degrees(std::asin(0.2 / 4));
  int cylinder = 0, wall = 0;
  for (int j = 0; j < 512; ++j) {
    const double azimuth = std::abs(tank.azimuth_deg(j));
    for (int n = 0; n < tank.polar.rows; ++n) {
      const int id = tank.instance(n, j);
      if (id == 2) {
        ++cylinder;
        CHECK(azimuth < half_width_deg + 0.1);
        CHECK(tank.range_m(n) > 3.8 - 0.026);
        CHECK(tank.range_m(n) < std::sqrt(16 - 0.04) / std::cos(radians(10)) + 0.026);
      }
      if (id == 1) {
        ++wall;
        CHECK(azimuth > half_width_deg - 0.1);
        CHECK(tank.range_m(n) > 5.5 - 0.026);
      }
    }
    // Every beam sees exactly one of the two.
    if (azimuth < half_width_deg - 0.1) CHECK(tank.ping.first_return_m[j] < 4.1f);
    if (azimuth > half_width_deg + 0.1) CHECK(tank.ping.first_return_m[j] > 5.4f);
  }
  CHECK(cylinder > 100);
  CHECK(wall > 1000);
}

// V17: dimming one of the two from 1e-3 to 1e-5 takes 20.0 dB from it and nothing from the other.
TEST_CASE("V17: reflectivity scales the echo it belongs to", "[figure]") {
  const auto energy_db = [](const std::string& scene, bool of_wall) {
    const SceneRun run(scene, {{"trajectory.pings", "1"}});
    const PingResult ping = run.ping(0);
    const int samples = run.session().record.samples;
    double sum = 0;
    for (int j = 0; j < 512; ++j) {
      const double azimuth = beam_azimuth_rad(run.session().sonar, j);
      const double off = std::abs(degrees(azimuth));
      for (int n = 0; n < samples; ++n) {
        const double range = sample_range_m(run.session().sonar, run.session().water, n);
        const double x = range * std::cos(azimuth);
        const bool wall = off > 5 && off < 10 && x > 5.4 && x < 5.9;
        const bool cylinder = off < 2 && range > 3.7 && range < 4.0;
        if (of_wall ? wall : cylinder) {
          sum += std::norm(std::complex<double>(ping.series[std::size_t(j) * samples + n]));
        }
      }
    }
    return 10 * std::log10(sum);
  };
  const double wall = energy_db("sonar_tank", true), cylinder = energy_db("sonar_tank", false);
  CHECK(energy_db("tank_dim_wall", true) - wall == Approx(-20).margin(0.1));
  CHECK(energy_db("tank_dim_wall", false) - cylinder == Approx(0).margin(0.1));
  CHECK(energy_db("tank_dim_target", true) - wall == Approx(0).margin(0.1));
  CHECK(energy_db("tank_dim_target", false) - cylinder == Approx(-20).margin(0.1));
}
