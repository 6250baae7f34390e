#include "app/session.h"

#include <map>

#include "app/cost.h"
#include "catch.h"
#include "core/units.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

// Protects the default water: Francois-Garrison at the carrier.
TEST_CASE("absorption comes from the water or is fixed") {
  const SceneRun run_default("sonar_tank");
  CHECK(run_default.session().water.absorption_db_m == Approx(0.2995).epsilon(0.01));
  const SceneRun fixed("sonar_tank", {{"water.absorption", "{fixed_db_m: 0.0354}"}});
  CHECK(fixed.session().water.absorption_db_m == 0.0354);
  const SceneRun simple("sonar_tank", {{"water.absorption", "{model: ainslie_mccolm}"}});
  CHECK(simple.session().water.absorption_db_m == Approx(0.2995).epsilon(0.1));
  CHECK(simple.session().water.absorption_db_m != run_default.session().water.absorption_db_m);
}

TEST_CASE("sound speed is fixed or comes from the water") {
  CHECK(SceneRun("sonar_tank").session().water.sound_speed_m_s == 1500);
  const SceneRun from(
      "sonar_tank",
      {{"water.sound_speed_m_s", "{from: {temperature_c: 10, salinity_psu: 35, depth_m: 0}}"}});
  CHECK(from.session().water.sound_speed_m_s == Approx(1489.8).margin(0.2));
}

TEST_CASE("noise power follows spectrum level and bandwidth") {
  const SceneRun run("sonar_tank", {{"noise.spectrum_level_db", "30"}});
  CHECK(level_db(run.info().noise_power_pa2) == Approx(74.76).margin(0.01));
}

// Protects the mount: it stands on the body that the trajectory moves.
TEST_CASE("the sonar sits on the body") {
  const SceneRun run("seabed_and_target", {{"sonar.mount.position_m", "[1, 0, 0]"}});
  const Pose start = sonar_pose(run.session(), 0), end = sonar_pose(run.session(), 10);
  CHECK(start.position_m.x == Approx(1));
  CHECK(end.position_m.x == Approx(1 + std::cos(radians(5))));
  CHECK(end.position_m.y == Approx(std::sin(radians(5))));
  CHECK(rotate(start.rotation, {1, 0, 0}).z == Approx(-std::sin(radians(20))));
}

// Protects splits: shares as asked for (10,000 draws, standard error 0.005), the same for a
// sequence whatever else runs.
TEST_CASE("splits are keyed draws with the shares asked for") {
  std::map<std::string, int> count;
  for (std::uint32_t s = 0; s < 10000; ++s) ++count[pick_split({0.7, 0.2, 0.1}, 4, s)];
  CHECK(count["train"] / 1e4 == Approx(0.7).margin(0.015));
  CHECK(count["val"] / 1e4 == Approx(0.2).margin(0.015));
  CHECK(count["test"] / 1e4 == Approx(0.1).margin(0.015));
  CHECK(pick_split({1, 0, 0}, 4, 17) == "train");
  CHECK(pick_split({0, 0, 2}, 4, 17) == "test");
}

TEST_CASE("cost counts the files") {
  const SceneRun run("sonar_tank", {{"sequences", "3"}, {"output.cartesian", "false"}});
  // Series, four of the polar image, one picture.
  CHECK(estimate_cost(run.session(), 2).files == 3 * 10 * 6 + 3 * 9 + 11);
}
