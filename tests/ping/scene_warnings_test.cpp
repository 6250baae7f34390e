// Scenes that are likely to be mistaken, and those that are not.
#include "ping/prepare_session.h"
#include "ping/scene_warnings.h"

#include <string>

#include "catch.h"
#include "results.h"
#include "run_scene.h"
#include "scenario/scenario.h"
#include "temporary_folder.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr const char* kEmptyScene = R"(ensonify: 1
name: scene
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 5, beams: {count: 24, fov_deg: 24}, rays: {elevation: 4}}
materials: {m: {reflectivity: 1e-3}}
objects:
)";

// A tetrahedron whose faces look outwards.
std::string tetrahedron(double edge_m) {
  const std::string e = std::to_string(edge_m);
  return "v 0 0 0\nv " + e + " 0 0\nv 0 " + e + " 0\nv 0 0 " + e +
         "\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
}

struct Scene {
  TemporaryFolder folder;

  std::vector<std::string> warnings(const std::string& objects) const {
    return scene_warnings(prepared(kEmptyScene + objects, {}, folder.path()));
  }
};

}  // namespace

// Protects from a night of empty images: CAD files are in millimetres.
TEST_CASE("a mesh of an unlikely size is told with its likely unit") {
  const Scene scene;
  const auto of = [&](double edge_m, const std::string& more) {
    scene.folder.write("t.obj", tetrahedron(edge_m));
    return scene.warnings("  - {name: t, material: m, shape: {mesh: {file: t.obj" + more +
                          "}}, pose: {position_m: [2, 0, 0]}}\n");
  };
  CHECK(of(660, "") ==
        std::vector<std::string>{"t: the mesh is 660 x 660 x 660 m; its unit may not "
                                 "be the meter: scale: 0.001 makes 0.66 x 0.66 x "
                                 "0.66 m"});
  CHECK(of(0.0005, "").at(0).ends_with("scale: 1000 makes 0.5 x 0.5 x 0.5 m"));
  CHECK(of(660, ", scale: 0.001").empty());
  CHECK(of(37, "").empty());  // a ship
  CHECK(of(99, "").empty());
  CHECK(of(0.011, "").empty());
}

TEST_CASE("the likely unit makes an object of likely size") {
  CHECK(likely_scale(37) == std::nullopt);
  CHECK(likely_scale(120) == 0.001);
  CHECK(likely_scale(37'000) == 0.001);
  CHECK(likely_scale(1000) == 0.001);
  CHECK(likely_scale(1e6) == std::nullopt);
  CHECK(likely_scale(1) == std::nullopt);
  CHECK(likely_scale(0.002) == 1000);
}

// Protects from a sonar that hears the inside of what it should see, for each kind of shape; beside
// the same shape there is nothing to say.
TEST_CASE("a sonar in something solid is told") {
  const Scene scene;
  scene.folder.write("t.obj", tetrahedron(3));
  const auto object = [](const std::string& shape, const std::string& position) {
    return "  - {name: it, material: m, shape: {" + shape + "}, pose: {position_m: " + position +
           "}}\n";
  };
  struct Case {
    std::string shape, around, beside, word;
  };
  const Case cases[] = {
      {"sphere: {radius_m: 1}", "[0.9, 0, 0]", "[1.1, 0, 0]", "inside it"},
      {"box: {size_m: [2, 2, 2]}", "[0.9, 0.9, 0]", "[0.9, 1.1, 0]", "inside it"},
      {"cylinder: {radius_m: 1, height_m: 2}", "[0.9, 0, 0]", "[0, 0, 1.1]", "inside it"},
      {"mesh: {file: t.obj}", "[-0.5, -0.5, -0.5]", "[-1.1, -1.1, -1.1]", "inside it"},
      {"heightfield: {size_m: [8, 8], cell_m: 1}", "[0, 0, 0.5]", "[0, 0, -0.5]", "below it"},
      {"box: {size_m: [4, 4, 4], inward_facing: true}", "[2.1, 0, 0]", "[1.9, 0, 0]",
       "outside the room it"},
  };
  for (const Case& of : cases) {
    INFO(of.shape);
    const auto told = scene.warnings(object(of.shape, of.around));
    REQUIRE(told.size() == 1);
    CHECK(told[0] == "ping 0: the sonar at (0, 0, 0) m is " + of.word);
    CHECK(scene.warnings(object(of.shape, of.beside)).empty());
  }
  CHECK(scene.warnings(object("plane: {}", "[0, 0, 1]")).empty());
}

// Protects from a range in millimetres.
TEST_CASE("a range from which nothing comes back is told") {
  const Scene scene;
  const std::string water =
      "  []\npoint_targets: [{name: p, target_strength_db: -30, position_m: [2, 0, 0]}]\n"
      "water: {absorption: {fixed_db_m: ";
  CHECK(contains(scene.warnings(water + "25.1}}\n").at(0), "no echoes from beyond 5 m"));
  CHECK(scene.warnings(water + "24.9}}\n").empty());
}

// Protects from data sets of noise alone.
TEST_CASE("a scene without anything to hear is told, with the other warnings") {
  const Scene scene;
  const auto told = scene.warnings("  []\nwater: {absorption: {fixed_db_m: 25.1}}\n");
  REQUIRE(told.size() == 2);
  CHECK(told[0] == "objects: the scene has no object, point target or volume, so no ping has an echo");
}

// Protects from doubled echoes of an entry that was pasted twice.
TEST_CASE("objects in one place are told once") {
  const Scene scene;
  std::string objects;
  for (int i = 0; i < 4; ++i) {
    objects += "  - {name: ball_" + std::to_string(i) +
               ", material: m, shape: {sphere: {radius_m: 0.2}}, pose: {position_m: [2, " +
               (i < 3 ? "0" : "0.1") + ", 0]}}\n";
  }
  CHECK(scene.warnings(objects) ==
        std::vector<std::string>{
            "ball_0 and ball_1 have the same place and the same size, and so do 1 "
            "more; copies of an entry need a sampled position or a place"});
}
