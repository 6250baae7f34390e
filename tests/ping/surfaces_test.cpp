// Surfaces of flat faces, and what annotations measure, against geometry.
#include <algorithm>
#include <cmath>

#include "catch.h"
#include "core/units.h"
#include "labels/surfaces.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr const char* kSurfacesScene = R"(ensonify: 1
name: surfaces
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 8
  beams: {count: 40, fov_deg: 20}
  rays: {elevation: 200, min_per_cell: 4}
  elevation: {fan_deg: 20}
materials: {m: {reflectivity: 1e-3}, rock: {reflectivity: 1e-1}}
output: {cartesian: false, png: false, surfaces: true}
)";

Annotation polar_annotation(const PingResult& ping, std::uint16_t instance) {
  const auto found = std::ranges::find(ping.polar_annotations, instance, &Annotation::instance);
  REQUIRE(found != ping.polar_annotations.end());
  return *found;
}

}  // namespace

// Protects normal and range of a face in the frame of a sonar that is turned and stands elsewhere:
// the box is turned by 30 degrees to the boresight, and its face towards the sonar lies in the
// plane n . p = -d with n = (-cos 30, -sin 30, 0). Rounding and the width of a beam in azimuth are
// allowed for.
TEST_CASE("the face of a box has its plane and its normal") {
  const SceneRun run = SceneRun::of_text(std::string(kSurfacesScene) + R"(
objects:
  - {name: box, class: box, material: m, shape: {box: {size_m: [1, 4, 1]}},
     pose: {position_m: [2, 6, 1], rotation_deg: [0, 0, 120]}}
trajectory: {poses: [{position_m: [2, 1, 1], rotation_deg: [0, 0, 90]}]}
)");
  const PingResult ping = run.ping(0);
  const LabelledImage& polar = *ping.polar;
  const double angle = radians(30);
  const Vec3 expected{-std::cos(angle), -std::sin(angle), 0};
  const double distance_m = 5 * std::cos(angle) - 0.5;
  const Sonar& sonar = run.session().sonar;
  int pixels = 0;
  for (std::size_t i = 0; i < polar.instance.size(); ++i) {
    if (polar.instance[i] != 1) continue;
    const Vec3 normal{polar.surface_normal_x[i], polar.surface_normal_y[i],
                      polar.surface_normal_z[i]};
    CHECK(length(normal - expected) < 1e-3);
    const int beam = static_cast<int>(i % static_cast<std::size_t>(polar.columns));
    const double azimuth = beam_azimuth_rad(sonar, beam), half = sonar.beam_spacing_rad / 2;
    const auto range_at = [&](double azimuth_rad) {
      return -distance_m / dot(expected, unit_vector(azimuth_rad, polar.surface_elevation_rad[i]));
    };
    const auto [low_m, high_m] = std::minmax({range_at(azimuth - half), range_at(azimuth + half)});
    CHECK(polar.surface_range_m[i] > low_m - 1e-3);
    CHECK(polar.surface_range_m[i] < high_m + 1e-3);
    ++pixels;
  }
  CHECK(pixels > 100);
}

// Protects two surfaces of one object in a pixel: ceiling and floor of a low room, which the sonar
// in the middle hears at the same range.
TEST_CASE("what is met above and below at one range is two surfaces") {
  const SceneRun run = SceneRun::of_text(std::string(kSurfacesScene) + R"(
objects:
  - {name: room, class: room, material: m, shape: {box: {size_m: [40, 40, 1.2], inward_facing: true}}}
)");
  const PingResult ping = run.ping(0);
  const LabelledImage& polar = *ping.polar;
  int pixels = 0;
  for (std::size_t i = 0; i < polar.instance.size(); ++i) {
    if (polar.instance[i] != 1) continue;
    CHECK(polar.surface_count[i] == 2);
    // Ceiling and floor at +-0.6 m.
    CHECK(polar.highest_range_m[i] * std::sin(polar.highest_elevation_rad[i]) ==
          Approx(0.6).margin(1e-3));
    CHECK(polar.lowest_range_m[i] * std::sin(polar.lowest_elevation_rad[i]) ==
          Approx(-0.6).margin(1e-3));
    CHECK(std::abs(polar.elevation_rad[i]) < 0.01);  // the mean is between them
    CHECK(std::abs(polar.surface_normal_z[i]) == Approx(1).margin(1e-3));
    ++pixels;
  }
  CHECK(pixels > 1000);
}

// Protects layover: two plates that face the sonar at equal range, one up and one down, are two
// surfaces in their pixels. They mirror each other, so that energies are as the reflectivities, 1
// to 100.
TEST_CASE("two plates at one range in a beam are a layover of two") {
  const SceneRun run = SceneRun::of_text(std::string(kSurfacesScene) + R"(
objects:
  - {name: upper, class: plate, material: m, shape: {box: {size_m: [0.02, 0.6, 0.6]}},
     pose: {position_m: [4.95, 0, 0.5], rotation_deg: [0, -5.767, 0]}}
  - {name: lower, class: plate, material: rock, shape: {box: {size_m: [0.02, 0.6, 0.6]}},
     pose: {position_m: [4.95, 0, -0.5], rotation_deg: [0, 5.767, 0]}}
)");
  const PingResult ping = run.ping(0);
  const LabelledImage& polar = *ping.polar;
  int pixels = 0, whole = 0;
  for (std::size_t i = 0; i < polar.instance.size(); ++i) {
    if (polar.instance[i] == 0) {
      CHECK(polar.layover_count[i] == 0);
      CHECK(polar.second_fraction[i] == 0);
      continue;
    }
    CHECK(polar.instance[i] == 2);
    CHECK(polar.second_instance[i] == 1);
    // The corners of a plate are farther away than its middle, which parts them.
    CHECK(polar.layover_count[i] == 2 * polar.surface_count[i]);
    whole += polar.surface_count[i] == 1;
    CHECK(polar.instance_fraction[i] == Approx(100.0 / 101).margin(1e-4));
    CHECK(polar.second_fraction[i] == Approx(1.0 / 101).margin(1e-4));
    ++pixels;
  }
  CHECK(whole > 20);
  CHECK(pixels > whole);
}

// Protects truncation from the pose to the annotation: a ball with its middle on the last range,
// and one on the edge of the sectors.
TEST_CASE("half a ball beyond a limit is truncated by one half") {
  const SceneRun run = SceneRun::of_text(std::string(kSurfacesScene) + R"(
objects:
  - {name: far, class: ball, material: m, shape: {sphere: {radius_m: 0.2}}, pose: {position_m: [8, 0, 0]}}
  - {name: aside, class: ball, material: m, shape: {sphere: {radius_m: 0.2}}, pose: {position_m: [4.924039, -0.868241, 0]}}
)");
  const PingResult ping = run.ping(0);
  // The sphere of the last range bends away by 0.2^2/16 m.
  CHECK(polar_annotation(ping, 1).measures.truncated == Approx(0.5 + 0.0025 / 0.4).margin(0.006));
  CHECK(polar_annotation(ping, 2).measures.truncated == Approx(0.5).margin(0.006));
  CHECK(std::isnan(polar_annotation(ping, 1).measures.contrast_db));
}

// Protects contrast by another route: the planes themselves. A plate with a hundred times the
// reflectivity of the wall right behind it stands out by nearly 20 dB; what leaks from it into the
// pixels beside it takes off a part.
TEST_CASE("contrast is that of the clean image") {
  const SceneRun run = SceneRun::of_text(std::string(kSurfacesScene) + R"(
objects:
  - {name: room, class: room, material: m, shape: {box: {size_m: [10, 10, 10], inward_facing: true}}}
  - {name: plate, class: plate, material: rock, shape: {box: {size_m: [0.02, 0.7, 2]}}, pose: {position_m: [4.99, 0, 0]}}
)");
  const PingResult ping = run.ping(0);
  const LabelledImage& polar = *ping.polar;
  const Annotation plate = polar_annotation(ping, 2);
  const auto [left, top, width, height] = plate.box;
  const int aside = std::max(8, width / 2), along = std::max(8, height / 2);
  double sum[3] = {};
  int count[3] = {};
  for (int row = std::max(0, top - along); row < std::min(polar.rows, top + height + along);
       ++row) {
    for (int column = std::max(0, left - aside);
         column < std::min(polar.columns, left + width + aside); ++column) {
      const std::size_t at = std::size_t(row) * polar.columns + column;
      sum[polar.instance[at]] += std::pow(10, polar.clean_db[at] / 10);
      ++count[polar.instance[at]];
    }
  }
  const double contrast = 10 * std::log10(sum[2] / count[2] / (sum[1] / count[1]));
  CHECK(plate.measures.contrast_db == Approx(contrast).margin(1e-3));
  CHECK(plate.measures.contrast_db > 10);
  CHECK(plate.measures.contrast_db < 21);
  CHECK(plate.measures.truncated == Approx(1 - 4.98 * std::tan(radians(10))).margin(0.01));
  CHECK(std::isnan(polar_annotation(ping, 1).measures.contrast_db));
}
