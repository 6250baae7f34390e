#include "app/starved_cells.h"

#include "catch.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// A sea bed at a slant, with few rays over it.
std::vector<std::string> warnings(const std::string& rays, const std::string& more = "") {
  const SceneRun run = SceneRun::of_text(
      "ensonify: 1\nsonar: {preset: blueview_p900_90, range_max_m: 8, beams: {count: 16, fov_deg: "
      "16}, elevation: {width_deg: 20, fan_deg: 40}, rays: " +
      rays +
      "}\nmaterials: {sand: {reflectivity: 1e-3}}\nobjects: [{name: bed, material: sand, shape: "
      "{plane: {}}, pose: {position_m: [0, 0, -1]}}]\ntrajectory: {pings: 1}\n" +
      more);
  return starved_warnings(run.session(), Tracer(run.session().world), Workers(2));
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

const std::string kFew = "{elevation: 30}", kByNeed = "{elevation: 30, per_cell: 20}";
const std::string kMany = "{elevation: 20000}";
const std::string kMirror = "multipath: {surface: {z_m: 1, reflection: -1}}\n";
const std::string kFixed = "scattering: {speckle: surface}\n";

}  // namespace

TEST_CASE("too few rays on a slanting bed are told, with what helps") {
  const auto few = warnings(kFew);
  REQUIRE(few.size() == 1);
  CHECK(holds(few[0], "sonar.rays.per_cell: 20 adds rays"));
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
    CHECK(holds(told[0], "echoes over mirrors"));
    CHECK(holds(told[0], "raise sonar.rays.elevation"));
  }
  CHECK(warnings(kFew, kMirror).size() == 1);
  CHECK(warnings(kMany, kMirror).empty());
}
