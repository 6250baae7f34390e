// The keys of a camera, and what is refused before anything is written.
#include <string>

#include "catch.h"
#include "ping/camera.h"
#include "ping/run_scene.h"
#include "ping/scene_warnings.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

Result<Scenario> read(const std::string& rest) {
  return parse_scenario(
      "ensonify: 1\nsonar: {preset: blueview_p900_90, beams: {count: 16}}\n" + rest, "scene.yaml",
      ".");
}

std::string error_of(const std::string& rest) {
  auto scenario = read(rest);
  if (!scenario) return scenario.error().message;
  const auto session = prepare_session(std::move(*scenario), 0);
  return session ? "" : session.error().message;
}

bool has(const std::string& text, const std::string& part) {
  INFO(text);
  const bool found = text.find(part) != std::string::npos;
  CHECK(found);
  return found;
}

}  // namespace

// Protects what a short scenario gets.
TEST_CASE("a camera of a field of view has defaults") {
  const Scenario scenario = value_of(read("camera: {fov_deg: 90}\n"));
  const CameraOptics optics = optics_of(*scenario.camera);
  CHECK(optics.width_px == 640);
  CHECK(optics.focal_x_px == Approx(320));
  CHECK(optics.focal_y_px == Approx(320));
  CHECK(optics.center_x_px == 319.5);
  CHECK(optics.center_y_px == 239.5);
  CHECK(scenario.output.selection.camera_geometry);
  CHECK(scenario.output.selection.camera_color);
  CHECK_FALSE(scenario.output.selection.camera_flow);
  // x along the axis of view is z of the camera's frame, and y to the left is -x.
  const Pose pose = camera_of(scenario)->in_sonar;
  CHECK(length(rotate(pose.rotation, {0, 0, 1}) - Vec3{1, 0, 0}) < 1e-12);
  CHECK(length(rotate(pose.rotation, {1, 0, 0}) - Vec3{0, -1, 0}) < 1e-12);
}

// Protects the resolved text: it reads back to itself, and has no key of a camera without one.
TEST_CASE("a camera survives its resolved text") {
  const auto name = [](const std::filesystem::path& file) { return file.string(); };
  const std::string keys =
      "camera: {focal_px: [300, 310], center_px: [1, 2], distortion: {k1: 0.1, p2: 0.01}, samples: "
      "2, "
      "light: {lamp: 3}, water: {attenuation_per_m: [1, 2, 3], veil: [0, 0.1, 0.2]}, surface_z_m: "
      "4}\n"
      "output: {camera: {geometry: false, flow: true}}\n";
  const std::string text = to_yaml(value_of(read(keys)), name);
  CHECK(to_yaml(value_of(parse_scenario(text, "again.yaml", ".")), name) == text);
  has(text, "k1: 0.1");
  has(text, "flow: true");
  CHECK(to_yaml(value_of(read("")), name).find("camera") == std::string::npos);
  const Scenario off = value_of(read("camera: {fov_deg: 60}\noutput: {camera: false}\n"));
  CHECK_FALSE(off.output.selection.any_camera());
}

// Protects the derived water: attenuations of Jerlov's table, the veil in inverse proportion.
TEST_CASE("a Jerlov type gives attenuation and veil") {
  const Scenario scenario = value_of(read("camera: {fov_deg: 60, water: {jerlov: 3C}}\n"));
  const CameraWater water = camera_of(scenario)->water;
  CHECK(water.attenuation_per_m == Rgb{0.33, 0.20, 0.29});
  CHECK(water.backscatter_per_m == water.attenuation_per_m);
  CHECK(water.veil[1] == Approx(0.2));
  CHECK(water.veil[0] == Approx(0.2 * 0.20 / 0.33));
}

TEST_CASE("cameras that cannot be are refused") {
  has(error_of("camera: {width_px: 320}\n"), "fov_deg");
  has(error_of("camera: {fov_deg: 60, focal_px: 300}\n"), "fov_deg");
  has(error_of("camera: {fov_deg: 100, distortion: {k1: -0.4}}\n"),
      "scene.yaml:3:36: camera.distortion: the distortion folds the image, so that nothing is "
      "seen");
  has(error_of("camera: {fov_deg: 60, water: {}}\n"), "jerlov");
  has(error_of("output: {camera: true}\n"), "the scenario has no camera");
  has(error_of("camera: {fov_deg: 60, surface_z_m: 1, mount: {position_m: [0, 0, 2]}}\n"),
      "camera.mount.position_m: at ping 0 the camera is at z = 2 m, not below the water surface at "
      "1 m");
  has(error_of("camera: {fov_deg: 60, mount: {position_m: [0, 0, 2]}}\n"
               "multipath: {surface: {z_m: 1.5, reflection: -1}}\n"),
      "not below the water surface at 1.5 m");
  CHECK(error_of("camera: {fov_deg: 60, surface_z_m: 1}\n").empty());
}

// Protects mounts inside the body of a vehicle.
TEST_CASE("a camera inside an object is warned of") {
  const std::string box =
      "materials: {m: {reflectivity: 1e-3}}\n"
      "objects: [{name: hull, material: m, shape: {box: {size_m: [1, 1, 1]}}, "
      "pose: {position_m: [-1, 0, 0]}}]\n";
  const auto warnings = [&](const std::string& x) {
    const Session session =
        prepared(read("camera: {fov_deg: 60, mount: {position_m: [" + x + ", 0, 0]}}\n" + box));
    std::string all;
    for (const std::string& text : scene_warnings(session)) all += text + "\n";
    return all;
  };
  has(warnings("-0.8"), "ping 0: the camera at (-0.8, 0, 0) m is inside hull");
  CHECK(warnings("-0.4").find("the camera") == std::string::npos);
}
