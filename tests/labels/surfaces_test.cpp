// Planes of surfaces from given echoes.
#include "labels/surfaces.h"

#include <atomic>
#include <cmath>
#include <utility>

#include "catch.h"
#include "labels/cartesian.h"
#include "polar_fixture.h"

using namespace ensonify;

namespace {

using test::direct_echo;
using test::kMeterBandwidth_hz;
using test::kMeterSpeed_m_s;

constexpr double kRayStep_rad = 0.01;

Scatterer bounced(Scatterer s) {
  s.path = 1;
  return s;
}

struct SurfaceScene : test::PolarPing {
  SurfaceScene(std::vector<Scatterer> echoes, int beams, int samples)
      : PolarPing(std::move(echoes), beams, samples, kMeterBandwidth_hz, {0, 1, 2, 3}) {}

  // Normals that say which scatterer they are of.
  LabelledImage surfaces(int threads = 2) {
    LabelledImage polar = image(threads);
    const NormalsAt normals = [&](std::span<const std::uint32_t> which, std::span<Vec3> found) {
      asked += static_cast<int>(which.size());
      for (std::size_t i = 0; i < which.size(); ++i) {
        found[i] = {0, 0, list.items[which[i]].arrival.elevation_rad > 0 ? 1.0 : -1.0};
      }
    };
    add_surfaces({input, kMeterSpeed_m_s, kRayStep_rad, normals}, Workers(threads), polar);
    return polar;
  }
  std::atomic<int> asked = 0;
};

constexpr double kAngleMargin_rad = kSurfaceAngleQuantum_rad,
                 kRangeMargin_m = kSurfaceRangeQuantum_m;

}  // namespace

// Protects the choice: the strongest echo is of the winner, whatever others bring, and has its own
// range and normal; lowest and highest are the extremes of elevation.
TEST_CASE("a pixel's surfaces are those of its instance") {
  SurfaceScene scene({direct_echo(0, 4.8, 1, 2, 0.2), direct_echo(0, 5.25, 1, 3, -0.1),
                      direct_echo(0, 5.5, 1, 1, 0.25), direct_echo(0, 5.1, 2, 5, 0.4)},
                     1, 10);
  const LabelledImage image = scene.surfaces();
  REQUIRE(image.instance[5] == 1);
  CHECK(image.surface_elevation_rad[5] == Approx(-0.1).margin(kAngleMargin_rad));
  CHECK(image.surface_range_m[5] == Approx(5.25).margin(kRangeMargin_m));
  CHECK(image.surface_normal_z[5] == -1);
  CHECK(image.lowest_elevation_rad[5] == Approx(-0.1).margin(kAngleMargin_rad));
  CHECK(image.lowest_range_m[5] == Approx(5.25).margin(kRangeMargin_m));
  CHECK(image.highest_elevation_rad[5] == Approx(0.25).margin(kAngleMargin_rad));
  CHECK(image.highest_range_m[5] == Approx(5.5).margin(kRangeMargin_m));
  CHECK(image.surface_count[5] == 3);
  CHECK(image.elevation_rad[5] > 0.15);  // the mean, that of no surface
}

// Protects layover: surfaces of all instances count, one for each instance and gap in elevation;
// the second instance is that with the most energy after the winner's, and its share is of all
// energy, with ghosts and volumes.
TEST_CASE("layover counts all surfaces and names the second instance") {
  SurfaceScene scene({direct_echo(0, 5, 1, 4, 0.2), direct_echo(0, 5.1, 1, 1, -0.2),
                      direct_echo(0, 5.2, 2, 3, 0.2), direct_echo(0, 5.3, 3, 1, 0.21),
                      bounced(direct_echo(0, 5.1, 3, 2, 0.1)), direct_echo(0, 9, 2, 1, 0)},
                     1, 12);
  scene.input.second = true;
  VolumeEcho water = test::empty_volume(3, 12);
  water.energy[5] = 0.5;
  water.energy[9] = 3;
  scene.volumes = {water};
  const LabelledImage image = scene.surfaces();
  REQUIRE(image.instance[5] == 1);
  CHECK(image.surface_count[5] == 2);
  CHECK(image.layover_count[5] == 4);
  CHECK(image.second_instance[5] == 2);
  CHECK(image.instance_fraction[5] == Approx(5 / 11.5));
  CHECK(image.second_fraction[5] == Approx(3 / 11.5));
  // The water is louder than the surface in it.
  CHECK(image.instance[9] == 3);
  CHECK(image.layover_count[9] == 1);
  CHECK(image.second_instance[9] == 2);
  CHECK(image.second_fraction[9] == Approx(0.25));
  // Nothing, and one instance alone.
  CHECK(image.layover_count[0] == 0);
  CHECK(image.second_instance[0] == 0);
  CHECK(image.second_fraction[0] == 0);
}

// Protects pixels without: no echo, no instance for noise, a volume, and what bounced.
TEST_CASE("pixels without a surface are blank") {
  SurfaceScene scene({direct_echo(0, 2, 1, 1, 0.1), direct_echo(0, 6, 2, 1, 0.1),
                      bounced(direct_echo(0, 6, 2, 9, 0.3))},
                     1, 12);
  scene.input.noise_power_pa2 = 1e-7;
  scene.clean[2] = 1e-8f;
  VolumeEcho water = test::empty_volume(3, 12);
  water.energy[10] = 1;
  scene.volumes = {water};
  const LabelledImage image = scene.surfaces();
  const auto is_blank = [&](int n) {
    return std::isnan(image.surface_elevation_rad[n]) && std::isnan(image.surface_range_m[n]) &&
           std::isnan(image.surface_normal_x[n]) && std::isnan(image.lowest_elevation_rad[n]) &&
           std::isnan(image.highest_range_m[n]) && image.surface_count[n] == 0;
  };
  REQUIRE(image.instance[10] == 3);
  for (const int n : {0, 2, 4, 9, 10, 11}) {
    INFO("sample " << n);
    CHECK(is_blank(n));
  }
  CHECK_FALSE(is_blank(1));
  CHECK(image.highest_elevation_rad[6] == Approx(0.1).margin(kAngleMargin_rad));
  CHECK(image.surface_count[6] == 1);
}

// Protects the definition: neighbours as far apart as rays are one surface, a missing ray parts
// two.
TEST_CASE("a gap of a ray in elevation parts two surfaces") {
  const auto count = [](std::vector<double> elevations) {
    std::vector<Scatterer> echoes;
    for (const double elevation : elevations) {
      echoes.push_back(direct_echo(0, 5, 1, 1, elevation));
    }
    SurfaceScene scene(std::move(echoes), 1, 10);
    return scene.surfaces().surface_count[5];
  };
  CHECK(count({0}) == 1);
  CHECK(count({0, kRayStep_rad, 2 * kRayStep_rad, 3 * kRayStep_rad}) == 1);
  CHECK(count({0, 2 * kRayStep_rad}) == 2);
  CHECK(count({0.1, -0.1, 0.1 + kRayStep_rad, -0.1 - kRayStep_rad, 0.1}) == 2);
  CHECK(count({0.1, 0, -0.1}) == 3);
}

// Protects the place of every pixel, and that threads change nothing.
TEST_CASE("surfaces do not depend on the number of threads") {
  std::vector<Scatterer> echoes;
  for (std::uint32_t beam = 0; beam < 40; ++beam) {
    for (int i = 0; i < 20; ++i) {
      echoes.push_back(direct_echo(beam, 2 + 0.37 * i, 1 + (beam + i) % 3, 1 + i % 5,
                                    0.01 * (beam % 7) - 0.004 * i));
    }
  }
  SurfaceScene one(echoes, 40, 12), many(echoes, 40, 12);
  const LabelledImage a = one.surfaces(1), b = many.surfaces(5);
  CHECK(one.asked < 40 * 12);  // a normal a scatterer, not a pixel
  int surfaces = 0;
  for (std::size_t i = 0; i < a.instance.size(); ++i) {
    CHECK(a.surface_count[i] == b.surface_count[i]);
    CHECK((a.surface_count[i] == 0) == (a.instance[i] == 0));
    if (a.instance[i] == 0) continue;
    CHECK(a.surface_elevation_rad[i] == b.surface_elevation_rad[i]);
    CHECK(a.surface_normal_z[i] == b.surface_normal_z[i]);
    CHECK(a.lowest_elevation_rad[i] <= a.surface_elevation_rad[i]);
    CHECK(a.highest_elevation_rad[i] >= a.surface_elevation_rad[i]);
    ++surfaces;
  }
  CHECK(surfaces > 200);
}

// Protects the Cartesian planes: those of the polar pixel, blank outside, and none where only ids
// are asked for.
TEST_CASE("surfaces are resampled through the map") {
  SurfaceScene scene({direct_echo(0, 5, 1, 1, 0.125)}, 1, 10);
  const LabelledImage polar = scene.surfaces();
  CartesianGrid grid;
  grid.height_px = 1;
  grid.width_px = 3;
  const LabelledImage all = resample(polar, grid, {5, -1, 0});
  CHECK(all.surface_elevation_rad[0] == 0.125f);
  CHECK(all.surface_count[0] == 1);
  for (const int outside : {1, 2}) {
    CHECK(std::isnan(all.highest_range_m[outside]));
    CHECK(all.surface_count[outside] == 0);
  }
  CHECK(resample(polar, grid, {5, -1, 0}, ResampledPlanes::ids).surface_count.empty());
}
