// What a session works out of a scenario, and the warning of too few scatterers.
#include <map>

#include "catch.h"
#include "core/units.h"
#include "ping/scene_warnings.h"
#include "ping/sequence_info.h"
#include "ping/session.h"
#include "results.h"
#include "run/cost.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

// Protects the default water: Francois-Garrison at the carrier.
TEST_CASE("absorption comes from the water or is fixed", "[figure]") {
  const SceneRun run_default("sonar_tank");
  CHECK(run_default.session().water.absorption_db_m == Approx(0.2995).epsilon(0.01));
  const SceneRun fixed("sonar_tank", {{"water.absorption", "{fixed_db_m: 0.0354}"}});
  CHECK(fixed.session().water.absorption_db_m == 0.0354);
  const SceneRun simple("sonar_tank", {{"water.absorption", "{model: ainslie_mccolm}"}});
  CHECK(simple.session().water.absorption_db_m == Approx(0.2995).epsilon(0.1));
  CHECK(simple.session().water.absorption_db_m != run_default.session().water.absorption_db_m);
}

TEST_CASE("sound speed is fixed or comes from the water", "[figure]") {
  CHECK(SceneRun("sonar_tank").session().water.sound_speed_m_s == 1500);
  const SceneRun from(
      "sonar_tank",
      {{"water.sound_speed_m_s", "{from: {temperature_c: 10, salinity_psu: 35, depth_m: 0}}"}});
  CHECK(from.session().water.sound_speed_m_s == Approx(1489.8).margin(0.2));
}

// 267 samples of 7.5 mm; the narrowest of so many bands takes the middle of a Gaussian spectrum.
TEST_CASE("looks whose range cells are longer than a quarter of the record are refused") {
  const std::string head =
      "ensonify: 1\nname: t\nsonar: {preset: aris_3000_hf, bandwidth_hz: 100000, range_max_m: 2, "
      "detector: {looks: ";
  check_fails(prepare_session(value_of(parse_scenario(head + "30}}\n", "scene.yaml", ".")), 0),
              ErrorKind::usage, {"sonar.detector.looks: in 30 sub-bands", "expected at most 26"});
  CHECK(prepared(head + "26}}\n").sonar.detector->looks == 26);
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
  CHECK(estimate_cost(run.session(), 0).files == 3 * 10 * 6 + 3 * 9 + 12);
}

namespace {

// A sea bed at a slant, with few rays over it.
std::vector<std::string> warnings(const std::string& rays, const std::string& more = "",
                                  const std::string& depth_m = "1") {
  const SceneRun run = SceneRun::of_text(
      "ensonify: 1\nsonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 8, "
      "beams: {count: 16, fov_deg: "
      "16}, elevation: {width_deg: 20, fan_deg: 40}, rays: " +
      rays +
      "}\nmaterials: {sand: {reflectivity: 1e-3}}\nobjects: [{name: bed, material: sand, shape: "
      "{plane: {}}, pose: {position_m: [0, 0, -" +
      depth_m + "]}}]\ntrajectory: {pings: 1}\n" + more);
  return gap_warnings(run.session(), Tracer(run.session().world), Workers(2));
}

const std::string kFew = "{elevation: 30}", kByNeed = "{elevation: 30, min_per_cell: 20}";
const std::string kMany = "{elevation: 20000}";
const std::string kMirror = "multipath: {surface: {z_m: 1, reflection: -1}}\n";
const std::string kFixed = "scattering: {speckle: surface}\n";

}  // namespace

TEST_CASE("too few rays on a slanting bed are told, with what helps") {
  const auto few = warnings(kFew);
  REQUIRE(few.size() == 1);
  CHECK(contains(few[0], "sonar.rays.min_per_cell: 20 adds rays"));
  CHECK(warnings(kByNeed).empty());
  CHECK(warnings(kMany).empty());
  CHECK(warnings(kFew, kFixed).empty());
}

// Protects against ghosts of a handful of scatterers beside a direct picture that is well.
TEST_CASE("bounced echoes are judged by the rays of the fan") {
  for (const auto& [rays, more] :
       {std::pair{kByNeed, kMirror}, std::pair{kFew, kMirror + kFixed}}) {
    const auto told = warnings(rays, more);
    REQUIRE(told.size() == 1);
    CHECK(contains(told[0], "specular and multipath echoes"));
    CHECK(contains(told[0], "raise sonar.rays.elevation"));
  }
  CHECK(warnings(kFew, kMirror).size() == 1);
  CHECK(warnings(kMany, kMirror).empty());
}

// Protects against a warning about rays that are not traced: straight ones of this fan end above
// the bed.
TEST_CASE("rays are judged where the water bends them to") {
  const std::string bending =
      "water: {sound_speed_m_s: 1500, profile: {depth_m: [0, 4], sound_speed_m_s: [1500, 1200]}}\n";
  CHECK(warnings(kFew, "", "3").empty());
  const auto told = warnings(kFew, bending, "3");
  REQUIRE(told.size() == 1);
  CHECK(contains(told[0], "sonar.rays.min_per_cell: 20 adds rays"));
}
