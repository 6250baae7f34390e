#include <cmath>

#include "catch.h"
#include "core/units.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::parse;

// Protects the hand-over to the stages: SI and radians, and no field forgotten.
TEST_CASE("the stages get SI units and radians") {
  const auto scenario = value_of(parse(
      "ensonify: 1\nname: t\nscattering: {normalization: mean_square}\nsonar: {frequency_hz: 9e5, "
      "bandwidth_hz: 3e4, pulse: flat, source_level_db: 200, range_min_m: 1, range_max_m: 20, "
      "beams: {count: 90, spacing_deg: 0.5, receive_width_deg: 2}, elevation: {width_deg: 10}, "
      "rays: {elevation: 5, azimuth: 4}}\n"));
  const Sonar sonar = sonar_of(scenario);
  CHECK(sonar.frequency_hz == 9e5);
  CHECK(sonar.bandwidth_hz == 3e4);
  CHECK(sonar.pulse.shape == PulseShape::flat);
  CHECK(sonar.source_level_db == 200);
  CHECK(sonar.range_min_m == 1);
  CHECK(sonar.range_max_m == 20);
  CHECK(sonar.beam_count == 90);
  CHECK(sonar.beam_spacing_rad == Approx(0.5 * kPi / 180));
  CHECK(sonar.beam_width_rad == Approx(2 * kPi / 180));
  CHECK(sonar.elevation_width_rad == Approx(10 * kPi / 180));
  CHECK(sonar.elevation_fan_rad == Approx(10 * kPi / 180));
  CHECK(sonar.rays_elevation == 5);
  CHECK(sonar.rays_azimuth == 4);
  CHECK(sonar.normalization == Normalization::mean_square);
}

// Protects the hand-over of what the signal chain adds.
TEST_CASE("the stages get pulse, window, shading, transmit width and converter") {
  const auto scenario = value_of(parse(
      "ensonify: 1\nsonar: {preset: seabat_f50, pulse: {lfm: {duration_s: 2e-3, taper: 0.3}}, "
      "window: hamming, beams: {shading: {taylor: {side_lobe_db: -40, nbar: 9}}, "
      "transmit_width_deg: 90}, elevation: {shading: chebyshev}, receiver: {adc: {bits: 8, "
      "full_scale_db: 160}}}\n"));
  const Sonar sonar = sonar_of(scenario);
  CHECK(sonar.pulse.shape == PulseShape::lfm);
  CHECK(sonar.pulse.duration_s == 2e-3);
  CHECK(sonar.pulse.taper == 0.3);
  CHECK(sonar.window == Window::hamming);
  CHECK(sonar.shading.kind == Shading::taylor);
  CHECK(sonar.shading.side_lobe_db == -40);
  CHECK(sonar.shading.nbar == 9);
  CHECK(sonar.transmit_width_rad == Approx(kPi / 2));
  CHECK(sonar.elevation_line.shading.kind == Shading::chebyshev);
  REQUIRE(sonar.adc);
  CHECK(sonar.adc->bits == 8);
  CHECK(sonar.adc->full_scale_db == 160);
}

// Protects the hand-over of the laws, and lambert_exponent as the default of materials.
TEST_CASE("the stages get a material's law and coherent part") {
  const auto scenario = value_of(parse(
      "ensonify: 1\nsonar: {preset: seabat_f50}\nscattering: {lambert_exponent: 2}\nmaterials:\n"
      "  a: {reflectivity: 1e-3}\n"
      "  b: {reflectivity: 1, law: {lambert: {exponent: 3}}, coherent: {model: rician, k: 4}}\n"
      "  c: {reflectivity: 2, law: lommel_seeliger, coherent: {model: kirchhoff, reflection: -1, "
      "roughness_rms_m: 0.5}}\n"));
  const auto material = [&](int i) {
    return material_of(scenario.materials[i], scenario.scattering);
  };
  CHECK(name_of(material(0).law) == "lambert");
  CHECK(std::get<Lambert>(material(0).law).exponent == 2);
  CHECK(material(0).reflectivity == 1e-3);
  CHECK(material(0).coherent == CoherentModel::none);
  CHECK(std::get<Lambert>(material(1).law).exponent == 3);
  CHECK(material(1).coherent == CoherentModel::rician);
  CHECK(material(1).rician_k == 4);
  CHECK(name_of(material(2).law) == "lommel_seeliger");
  CHECK(material(2).coherent == CoherentModel::kirchhoff);
  CHECK(material(2).reflection == -1);
  CHECK(material(2).roughness_rms_m == 0.5);
}

// Protects the convention: roll, pitch, yaw in degrees, z-y'-x'', positive pitch nose down.
TEST_CASE("a pose follows the convention of its rotation") {
  PoseSpec spec;
  spec.position_m = {1, 2, 3};
  spec.rotation = std::array<double, 3>{0, 90, 0};
  const Vec3 nose = rotate(pose_of(spec).rotation, {1, 0, 0});
  CHECK(nose.z == Approx(-1));
  CHECK(pose_of(spec).position_m == Vec3{1, 2, 3});
  spec.rotation = std::array<double, 3>{90, 0, 90};
  const Vec3 port = rotate(pose_of(spec).rotation, {0, 1, 0});
  CHECK(port.z == Approx(1));
  const Vec3 bow = rotate(pose_of(spec).rotation, {1, 0, 0});
  CHECK(bow.y == Approx(1));
}

// Protects every later rotation: a quaternion of any length is accepted and made a unit one here.
TEST_CASE("a quaternion is normalised") {
  PoseSpec spec;
  spec.rotation = Quat{2, 0, 0, 2};
  const Quat q = pose_of(spec).rotation;
  CHECK(q.w == Approx(std::sqrt(0.5)));
  CHECK(q.z == Approx(std::sqrt(0.5)));
}

}  // namespace
}  // namespace ensonify
