// Files that nobody on the project made. ENSONIFY_REAL_DATA names their folder; where it is not
// set the tests say so and pass.
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>

#include "catch.h"
#include "ping/session.h"
#include "results.h"
#include "run/runs.h"
#include "temporary_folder.h"
#include "verified.h"

using namespace ensonify;
using namespace ensonify::test;
namespace fs = std::filesystem;

namespace {

std::optional<fs::path> real_data(const std::string& name) {
  const char* folder = std::getenv("ENSONIFY_REAL_DATA");
  if (folder != nullptr && fs::exists(fs::path(folder) / name)) return fs::path(folder) / name;
  std::cout << "skipped: " << name << " is not there; ENSONIFY_REAL_DATA names its folder\n";
  return std::nullopt;
}

struct MeshExtent {
  Vec3 low{1e30, 1e30, 1e30}, high{-1e30, -1e30, -1e30};
};

MeshExtent extent_of(const Mesh& mesh) {
  MeshExtent e;
  for (const auto& v : mesh.vertices) {
    e.low = {std::min<double>(e.low.x, v[0]), std::min<double>(e.low.y, v[1]),
             std::min<double>(e.low.z, v[2])};
    e.high = {std::max<double>(e.high.x, v[0]), std::max<double>(e.high.y, v[1]),
              std::max<double>(e.high.z, v[2])};
  }
  return e;
}

void generate_with(const std::string& objects, const std::string& trajectory) {
  const TemporaryFolder folder;
  GenerateOptions options;
  options.input.scenario =
      folder.write("real.yaml",
                   "ensonify: 1\nname: real\n"
                   "sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 12,\n"
                   "        beams: {count: 64, fov_deg: 90}}\n"
                   "materials: {m: {reflectivity: 1e-2}}\n" +
                       objects + trajectory + "output: {cartesian: {height_px: 100}}\n");
  options.output = folder.path() / "out";
  options.quiet = true;
  require_ok(generate(options));
  require_ok(verified(options.output));
  // Something was heard: the instance has an annotation.
  std::ifstream coco(options.output / "coco.json");
  const std::string text(std::istreambuf_iterator<char>(coco), {});
  CHECK(contains(text, "\"bbox\""));
}

std::string object(const fs::path& file, const std::string& rest, const std::string& position) {
  return "objects: [{name: thing, material: m, shape: {mesh: {file: " + file.string() + rest +
         "}}, pose: {position_m: " + position + "}}]\n";
}

}  // namespace

TEST_CASE("real: the tank's cylinder, STL", "[serial]") {
  if (const auto file = real_data("cylinder_sonar_tank.stl")) {
    generate_with(object(*file, "", "[4, 0, 0]"), "");
  }
}

TEST_CASE("real: a can, OBJ", "[serial]") {
  if (const auto file = real_data("coke_can.obj")) {
    generate_with(object(*file, ", scale: 5, normals: smooth", "[2, 0, 0]"), "");
  }
}

TEST_CASE("real: a torpedo, DAE, z up and in metres", "[serial]") {
  if (const auto file = real_data("torpedo_mk46.dae")) {
    const auto mesh = value_of(load_mesh(*file, {1, 1, 1}, Normals::face));
    const MeshExtent e = extent_of(mesh);
    // 2.64 m long, 0.32 m thick, lying along x, as its vertices say.
    CHECK(e.high.x - e.low.x == Approx(2.636).margin(1e-3));
    CHECK(e.high.z == Approx(0.162).margin(1e-3));
    CHECK(e.low.z == Approx(-0.162).margin(1e-3));
    generate_with(object(*file, "", "[4, 0, 0]"), "");
  }
}

TEST_CASE("real: a measured seabed, DAE, z up and in metres", "[serial]") {
  if (const auto file = real_data("herkules_seabed.dae")) {
    const auto mesh = value_of(load_mesh(*file, {1, 1, 1}, Normals::face));
    const MeshExtent e = extent_of(mesh);
    // A plate of 2 x 2 x 0.186 in its file, placed by a matrix that scales by 50, 49.93 and 20.
    CHECK(e.high.x - e.low.x == Approx(100).margin(1e-3));
    CHECK(e.low.z == Approx(0).margin(1e-3));
    CHECK(e.high.z == Approx(0.1860453 * 20).margin(1e-3));
    generate_with(object(*file, "", "[0, 0, -2]"), "");
  }
}

TEST_CASE("real: hand-held motion, TUM", "[serial]") {
  if (const auto file = real_data("freiburg1_xyz_groundtruth.tum")) {
    generate_with(
        "objects: [{name: room, material: m, shape: {box: {size_m: [9, 9, 9], inward_facing: "
        "true}}}]\n",
        "trajectory: {file: " + file->string() + ", ping_rate_hz: 1, pings: 6}\n");
  }
}

// Protects all of them together: things placed on a real seabed, a real hand's motion above it, the
// torpedo under way.
TEST_CASE("real: seabed, torpedo, can and the real trajectory in one scene") {
  const auto seabed = real_data("herkules_seabed.dae"), torpedo = real_data("torpedo_mk46.dae"),
             can = real_data("coke_can.obj"), motion = real_data("freiburg1_xyz_groundtruth.tum");
  if (!seabed || !torpedo || !can || !motion) return;
  const auto mesh = [](const fs::path& file) {
    return "material: m, shape: {mesh: {file: " + file.string() + "}}";
  };
  generate_with(
      "objects:\n"
      "  - {name: seabed, class: seabed, " +
          mesh(*seabed) +
          ", pose: {position_m: [0, 0, -4]}}\n"
          "  - {name: can, count: 5, class: can, " +
          mesh(*can) +
          ", place: {on: seabed, area_m: [[2, -2], [6, 2]]}}\n"
          "  - {name: torpedo, class: torpedo, " +
          mesh(*torpedo) +
          ", trajectory: {spline: {points_m: [[5, -3, 0], [6, 0, 0.5], [5, 3, 0]], speed_m_s: 1,\n"
          "     start_time_s: 1305031098}}}\n",
      "trajectory: {file: " + motion->string() + ", ping_rate_hz: 1, pings: 6}\n");
}
