// Mask, elevation and surfaces of a ball over the floor, against closed forms.
#include <cmath>
#include <limits>

#include "catch.h"
#include "labels/surfaces.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// The ball is as high as the sonar; the floor is met beyond it only.
constexpr const char* kBall = R"(ensonify: 1
name: ball
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 9
  beams: {count: 41, fov_deg: 20.5}
  rays: {elevation: 401}
  elevation: {fan_deg: 30}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: floor, class: floor, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -2]}}
  - {name: ball, class: ball, material: m, shape: {sphere: {radius_m: 0.5}}, pose: {position_m: [5, 0.3, 0]}}
output: {cartesian: {height_px: 400, exr: true}, surfaces: true}
)";
constexpr double kDistance_m = 5, kAside_m = 0.3, kRadius_m = 0.5;
constexpr int kBeams = 41, kRays = 401;

// The ball as the upright plane through a beam cuts it: a circle.
struct Slice {
  double ahead_m = 0, radius_m = 0;  // no circle: radius 0
};

Slice slice_of(double azimuth_rad) {
  const double off = kAside_m * std::cos(azimuth_rad) - kDistance_m * std::sin(azimuth_rad);
  const double ahead = kDistance_m * std::cos(azimuth_rad) + kAside_m * std::sin(azimuth_rad);
  return {ahead, std::sqrt(std::max(0.0, kRadius_m * kRadius_m - off * off))};
}

// The range at which a ray of this elevation meets the circle; infinity where it does not.
double range_of(const Slice& slice, double elevation_rad) {
  const double along = slice.ahead_m * std::cos(elevation_rad);
  const double across = slice.ahead_m * std::sin(elevation_rad);
  const double under = slice.radius_m * slice.radius_m - across * across;
  const bool missed = slice.radius_m == 0 || under < 0;
  return missed ? std::numeric_limits<double>::infinity() : along - std::sqrt(under);
}

double ray_elevation(const Sonar& sonar, int ray) {
  return sonar.elevation_fan_rad * ((ray + 0.5) / kRays - 0.5);
}

}  // namespace

// Protects the outline: a pixel is the ball's exactly where one of the beam's rays meets the circle
// within c/2b of its sample. Pixels within 1e-3 samples of such a limit are left out.
TEST_CASE("the mask of a ball has the outline of its circles") {
  const SceneRun run = SceneRun::of_text(kBall);
  const PingResult ping = run.ping(0);
  const LabelledImage& polar = *ping.polar;
  const double step_m = sample_range_m(run.session().sonar, run.session().water, 1);
  int balls = 0;
  for (int beam = 0; beam < kBeams; ++beam) {
    const Slice slice = slice_of(beam_azimuth_rad(run.session().sonar, beam));
    for (int n = 0; n < static_cast<int>(6 / step_m); ++n) {
      double nearest = std::numeric_limits<double>::infinity();
      for (int ray = 0; ray < kRays; ++ray) {
        const double range_m = range_of(slice, ray_elevation(run.session().sonar, ray));
        nearest = std::min(nearest, std::abs(range_m / step_m - n));
      }
      if (std::abs(nearest - 1) < 1e-3) continue;
      const bool is_ball = nearest < 1;
      INFO("beam " << beam << " sample " << n);
      REQUIRE(polar.instance[std::size_t(n) * kBeams + beam] == (is_ball ? 2 : 0));
      balls += is_ball;
    }
  }
  CHECK(balls > 200);
}

// Protects elevation and its spread. At a range r the ball is met at plus and minus
// acos((r^2 + a^2 - q^2) / (2 r a)), a and q being the circle's distance and radius: the mean is 0,
// the spread lies between those of the ranges within a sample of the pixel's.
TEST_CASE("a ball as high as the sonar has elevation 0 and the spread of its circles") {
  const SceneRun run = SceneRun::of_text(kBall);
  const PingResult ping = run.ping(0);
  const LabelledImage& polar = *ping.polar;
  const double step_m = sample_range_m(run.session().sonar, run.session().water, 1);
  int pixels = 0;
  for (int beam = 0; beam < kBeams; ++beam) {
    const Slice slice = slice_of(beam_azimuth_rad(run.session().sonar, beam));
    const double a = slice.ahead_m, q = slice.radius_m;
    const auto angle_at = [&](double range_m) {
      const double cosine = (range_m * range_m + a * a - q * q) / (2 * range_m * a);
      return std::acos(std::clamp(cosine, -1.0, 1.0));
    };
    const double last_m = std::sqrt(a * a - q * q);  // where rays touch
    for (int n = 0; n < static_cast<int>(6 / step_m); ++n) {
      const std::size_t at = std::size_t(n) * kBeams + beam;
      if (polar.instance[at] != 2) continue;
      const double near_m = std::max((n - 1) * step_m, a - q);
      const double far_m = std::min((n + 1) * step_m, last_m);
      INFO("beam " << beam << " sample " << n);
      CHECK(std::abs(polar.elevation_rad[at]) < 1e-5);
      CHECK(polar.elevation_std_rad[at] > angle_at(near_m) - 1e-4);
      CHECK(polar.elevation_std_rad[at] < angle_at(far_m) + 1e-4);
      CHECK(polar.instance_fraction[at] == 1);
      ++pixels;
    }
  }
  CHECK(pixels > 200);
}

// Protects the planes of surfaces by the circles: the rays that meet the ball within a sample of a
// pixel say which elevations it holds, that gaps between them part its surfaces, and that the
// lowest and the highest are as far from the middle. The pixel of the nearest point holds just
// that.
TEST_CASE("the surfaces of a ball are those of its circles") {
  const SceneRun run = SceneRun::of_text(kBall);
  const PingResult ping = run.ping(0);
  const LabelledImage& polar = *ping.polar;
  const Sonar& sonar = run.session().sonar;
  const double step_m = sample_range_m(sonar, run.session().water, 1);
  int two = 0;
  for (int beam = 0; beam < kBeams; ++beam) {
    const Slice slice = slice_of(beam_azimuth_rad(sonar, beam));
    for (int n = 0; n < static_cast<int>(6 / step_m); ++n) {
      const std::size_t at = std::size_t(n) * kBeams + beam;
      if (polar.instance[at] != 2) continue;
      int count = 0, lowest = kRays, before = -kRays;
      bool is_sure = true;
      for (int ray = 0; ray < kRays; ++ray) {
        const double off = std::abs(range_of(slice, ray_elevation(sonar, ray)) / step_m - n);
        is_sure = is_sure && std::abs(off - 1) > 1e-3;
        if (off > 1) continue;
        count += ray > before + 1;
        lowest = std::min(lowest, ray);
        before = ray;
      }
      if (!is_sure) continue;
      INFO("beam " << beam << " sample " << n);
      CHECK(polar.surface_count[at] == count);
      const auto rad = Approx(ray_elevation(sonar, lowest)).margin(kSurfaceAngleQuantum_rad);
      CHECK(polar.lowest_elevation_rad[at] == rad);
      CHECK(polar.highest_elevation_rad[at] == -polar.lowest_elevation_rad[at]);
      two += count == 2;
    }
    const double nearest_m = slice.ahead_m - slice.radius_m;
    const auto at = std::size_t(std::lround(nearest_m / step_m)) * kBeams + beam;
    if (slice.radius_m < 0.2) continue;
    CHECK(polar.surface_elevation_rad[at] == Approx(0).margin(kSurfaceAngleQuantum_rad));
    CHECK(polar.surface_range_m[at] == Approx(nearest_m).margin(kSurfaceRangeQuantum_m));
  }
  CHECK(two > 200);
}

// Protects that range, elevation and normal belong together: every point lies on the ball, and the
// normal is the radius through it.
TEST_CASE("points of a ball's surfaces lie on it, with its radii as normals") {
  const SceneRun run = SceneRun::of_text(kBall);
  const PingResult ping = run.ping(0);
  const LabelledImage& polar = *ping.polar;
  const Vec3 centre{kDistance_m, kAside_m, 0};
  int points = 0;
  for (std::size_t i = 0; i < polar.instance.size(); ++i) {
    if (polar.instance[i] != 2) continue;
    const double azimuth = beam_azimuth_rad(run.session().sonar, static_cast<int>(i % kBeams));
    const auto radius_to = [&](double range_m, double elevation_rad) {
      return range_m * unit_vector(azimuth, elevation_rad) - centre;
    };
    const Vec3 radius = radius_to(polar.surface_range_m[i], polar.surface_elevation_rad[i]);
    const Vec3 normal{polar.surface_normal_x[i], polar.surface_normal_y[i],
                      polar.surface_normal_z[i]};
    CHECK(length(radius) == Approx(kRadius_m).margin(2e-4));
    CHECK(length(normal - (1 / kRadius_m) * radius) < 1e-3);
    CHECK(length(radius_to(polar.lowest_range_m[i], polar.lowest_elevation_rad[i])) ==
          Approx(kRadius_m).margin(2e-4));
    CHECK(length(radius_to(polar.highest_range_m[i], polar.highest_elevation_rad[i])) ==
          Approx(kRadius_m).margin(2e-4));
    ++points;
  }
  CHECK(points > 200);
}

// Protects annotations: the ball is whole and stands before no floor; the floor has no end.
TEST_CASE("annotations say what is cut off, in both views") {
  const SceneRun run = SceneRun::of_text(kBall);
  const PingResult ping = run.ping(0);
  for (const auto* list : {&ping.polar_annotations, &ping.cartesian_annotations}) {
    REQUIRE(list->size() == 2);
    CHECK(std::isnan((*list)[0].measures.truncated));
    CHECK(std::isnan((*list)[0].measures.contrast_db));
    CHECK((*list)[1].measures.truncated == 0);
  }
}
