// A quad with an image: the factor of each hit, and the expected energy, against closed forms.
#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <vector>

#include "catch.h"
#include "surface_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr double kHalf_m = 1.5;  // of the quad's side

// The quad x = 0, facing -x, with u along y and v along z from `low` to `high`.
MeshShape quad(float low, float high, std::shared_ptr<const ReflectivityImage> image) {
  auto mesh = std::make_shared<Mesh>();
  const auto h = static_cast<float>(kHalf_m);
  mesh->vertices = {{0, -h, -h}, {0, h, -h}, {0, h, h}, {0, -h, h}};
  mesh->uv = {{low, low}, {high, low}, {high, high}, {low, high}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  return {mesh, false, std::move(image)};
}

// The factor a + b u within the image, linear between the centers of its pixels.
std::shared_ptr<const ReflectivityImage> ramp(double a, double b, int columns = 64) {
  auto image = std::make_shared<ReflectivityImage>();
  image->rows = 1;
  image->columns = columns;
  for (int i = 0; i < columns; ++i) {
    image->factors.push_back(static_cast<float>(a + b * (i + 0.5) / columns));
  }
  return image;
}

double diffuse_energy(const std::vector<Scatterer>& scatterers) {
  double sum = 0;
  for (const Scatterer& s : scatterers) {
    sum += std::norm(std::complex<double>(s.mean)) +
           double{s.standard_deviation} * double{s.standard_deviation};
  }
  return sum;
}

SurfaceScene scene_of(MeshShape shape) {
  return {world_of({{1, std::move(shape), {{5, 0, 0}, {}}, diffuse()}}), narrow_sonar(8), {{}}};
}

}  // namespace

// u = y/3 + 1/2 within the innermost 1/2 of the image, which stays clear of its edges. A factor is
// a float.
TEST_CASE("a hit on a quad has the factor of its place") {
  const Pose pose{{5, -2, 1}, from_roll_pitch_yaw(0.3, -0.2, 0.5)};
  const World world = world_of({{1, quad(0, 1, ramp(0.1, 0.8)), pose, diffuse()}});
  const Tracer tracer(world);
  for (int i = 0; i < 60; ++i) {
    for (int j = 0; j < 10; ++j) {
      const Vec3 place{0, 1.4 * (i / 30.0 - 1), 1.4 * (j / 5.0 - 1)};
      const Vec3 from = transform_point(pose, place + Vec3{-4, 0.3, -0.5});
      const Vec3 direction = normalized(transform_point(pose, place) - from);
      const Hit hit = tracer.first_hit({from, direction}, 20);
      REQUIRE(hit.instance == 1);
      const double factor = 0.1 + 0.8 * (place.y / (2 * kHalf_m) + 0.5);
      REQUIRE(hit.reflectivity == Approx(factor).epsilon(1e-6));
      const auto along = tracer.hits_along({from, direction}, 20);
      REQUIRE(along.at(0).reflectivity == hit.reflectivity);
    }
  }
}

// Four rows of a step along v: the upper half is black. Repeated three times over the quad, v of
// height z is 3 (z/3 + 1/2) + 0.5, so that the quad begins in the middle of the image.
TEST_CASE("a step repeats over a quad, with v up") {
  auto image = std::make_shared<ReflectivityImage>();
  image->rows = 4;
  image->columns = 1;
  image->factors = {0, 0, 1, 1};
  const World world = world_of({{1, quad(0.5f, 3.5f, image), {{5, 0, 0}, {}}, diffuse()}});
  const Tracer tracer(world);
  for (int i = 0; i < 300; ++i) {
    const double z = kHalf_m * (2 * (i + 0.5) / 300 - 1);
    const double v = z + kHalf_m + 0.5, within = v - std::floor(v);
    // Within half a pixel of a step it is a ramp.
    double factor = std::clamp(0.5 - 4 * (within - 0.5), 0.0, 1.0);
    if (within < 0.125) factor = 0.5 + 4 * within;
    if (within > 0.875) factor = 0.5 - 4 * (1 - within);
    const Hit hit = tracer.first_hit({{0, 0.2, z}, {1, 0, 0}}, 20);
    REQUIRE(hit.instance == 1);
    INFO(within);
    REQUIRE(hit.reflectivity == Approx(factor).margin(1e-6));
  }
}

// Rays on either side of y = 0 have factors that add up to 2 (a + b/2), so the expected energy is
// that of an even quad of a + b/2; per scatterer, energy follows the factor of its place.
TEST_CASE("the expected energy of a ramp is that of its middle") {
  const SurfaceScene even = scene_of(quad(0.1f, 0.9f, nullptr));
  const SurfaceScene graded = scene_of(quad(0.1f, 0.9f, ramp(0.2, 0.6)));
  const Fan fan = make_fan(even.sonar);
  const auto list = [&](const SurfaceScene& scene) {
    const auto hits = scene.tracer.trace_fan(fan, {}, 8, Workers(1));
    return surface_scatterers(fan, hits, scene.scattering);
  };
  const auto a = list(even), b = list(graded);
  REQUIRE(a.size() == b.size());
  REQUIRE(a.size() > 500);
  CHECK(diffuse_energy(b) / diffuse_energy(a) == Approx(0.5).epsilon(1e-5));
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double u = 0.1 + 0.8 * (a[i].position_m.y / (2 * kHalf_m) + 0.5);
    const double ratio = double{b[i].standard_deviation} / double{a[i].standard_deviation};
    REQUIRE(ratio * ratio == Approx(0.2 + 0.6 * u).epsilon(1e-5));
  }
}

// The same scatterers with and without the image, each weighed by the factor of its place.
TEST_CASE("scatterers fixed on a quad follow its image") {
  const SurfaceScene even = scene_of(quad(0.1f, 0.9f, nullptr));
  const SurfaceScene graded = scene_of(quad(0.1f, 0.9f, ramp(0.2, 0.6)));
  const ScattererList a = even.at({}), b = graded.at({});
  REQUIRE(a.items.size() == b.items.size());
  REQUIRE(a.items.size() > 1000);
  for (std::size_t i = 0; i < a.items.size(); ++i) {
    REQUIRE(a.items[i].key == b.items[i].key);
    const double u = 0.1 + 0.8 * (a.items[i].position_m.y / (2 * kHalf_m) + 0.5);
    const double ratio =
        double{b.items[i].standard_deviation} / double{a.items[i].standard_deviation};
    REQUIRE(ratio * ratio == Approx(0.2 + 0.6 * u).epsilon(1e-4));
  }
}
