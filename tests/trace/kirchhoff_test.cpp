// Coherent echoes of smooth bodies, by the sum of their scatterers at one frequency with the patterns
// divided out, against the surface integral. tests/verification/coherent.py has the closed forms V18 to V20.
#include "trace/scatter.h"

#include <cmath>
#include <complex>
#include <functional>
#include <set>

#include "catch.h"
#include "core/units.h"
#include "round_meshes.h"
#include "sonar_fixture.h"
#include "trace/plain_world.h"
#include "world/curved_mesh.h"

using namespace ensonify;

namespace {

constexpr double kSoundSpeed_m_s = 1500;
constexpr double kAtCarrier = 900e3;
const Water kLosslessWater{kSoundSpeed_m_s, 0};

Sonar sonar_of(int beams, int rays, double fov_rad, double fan_rad) {
  return test::fan_sonar(beams, fov_rad, 12, rays, fan_rad);
}

World mirror_world(Shape shape, Pose pose) {
  Material mirror;
  mirror.coherent = CoherentModel::kirchhoff;
  mirror.reflection = 1;
  return world_with(std::move(shape), pose, mirror);
}

std::vector<Scatterer> echoes_of(const World& world, const Sonar& sonar, int threads = 2) {
  const Tracer tracer(world);
  const Fan fan = make_fan(sonar);
  const Workers workers(threads);
  const auto hits = tracer.trace_fan(fan, {}, sonar.range_max_m, workers);
  return kirchhoff_scatterers(fan, hits, tracer, {},
                              make_surface_scattering(sonar, kLosslessWater, world), workers);
}

// One side of a body: place and outward normal times area element over (u, v) in [0, 1]^2.
struct SurfacePoint {
  Vec3 place_m;
  Vec3 area_m2;
};
using SurfacePatch = std::function<SurfacePoint(double, double)>;

// (i/lambda_c) int cos(alpha) r^-2 e^(-i 2k (r - reference)) dS over what faces the origin, by the
// rule of middles; of a convex body that is what the sonar sees.
std::complex<double> surface_integral(const std::vector<SurfacePatch>& patches, int nu, int nv,
                                      double frequency_hz, double reference_m) {
  std::complex<double> sum = 0;
  for (const SurfacePatch& patch : patches) {
    for (int i = 0; i < nu; ++i) {
      for (int k = 0; k < nv; ++k) {
        const SurfacePoint p = patch((i + 0.5) / nu, (k + 0.5) / nv);
        const double r = length(p.place_m);
        const double facing = -dot(p.place_m, p.area_m2) / r / (double(nu) * nv);
        if (facing <= 0) continue;
        const double phase = 4 * kPi * frequency_hz / kSoundSpeed_m_s * (r - reference_m);
        sum += facing / (r * r) * std::polar(1.0, -phase);
      }
    }
  }
  return std::complex<double>(0, kAtCarrier / kSoundSpeed_m_s) * sum;
}

// The front face of a box.
SurfacePatch front_of(const Pose& pose, const BoxShape& box) {
  const Vec3 half = box.half_size_m;
  return [=](double u, double v) {
    return SurfacePoint{
        transform_point(pose, {-half.x, half.y * (2 * u - 1), half.z * (2 * v - 1)}),
        rotate(pose.rotation, {-4 * half.y * half.z, 0, 0})};
  };
}

}  // namespace

// Protects bodies in any attitude, and the phase: the sum is the surface integral as a complex
// number, to 1 % of the broadside echo, whether the side or a rim throws it back.
TEST_CASE("a tilted cylinder is its surface integral", "[figure]") {
  const double a = 0.05, h = 0.1, r = 3;
  const auto patches_of = [&](const Pose& pose) {
    std::vector<SurfacePatch> patches{[=](double u, double v) {
      const Vec3 out{std::cos(2 * kPi * u), std::sin(2 * kPi * u), 0};
      return SurfacePoint{transform_point(pose, a * out + Vec3{0, 0, h * (2 * v - 1)}),
                          4 * kPi * a * h * rotate(pose.rotation, out)};
    }};
    for (const double end : {-1.0, 1.0}) {
      patches.push_back([=](double u, double v) {
        const double rho = a * u, angle = 2 * kPi * v;
        return SurfacePoint{
            transform_point(pose, {rho * std::cos(angle), rho * std::sin(angle), end * h}),
            2 * kPi * a * rho * rotate(pose.rotation, {0, 0, end})};
      });
    }
    return patches;
  };
  const Sonar sonar = sonar_of(64, 40, radians(11), radians(7));
  const double broadside =
      std::abs(surface_integral(patches_of({{r + a, 0, 0}, {}}), 800, 500, kAtCarrier, r));
  for (const double tilt : {0.0, 0.4, 2.0, 25.0, 90.0}) {
    INFO(tilt);
    const Pose pose{{r + a, 0.02, 0.01}, from_roll_pitch_yaw(0, radians(tilt), 0.3)};
    const auto model =
        sum_of_echoes(echoes_of(mirror_world(CylinderShape{a, h}, pose), sonar), kAtCarrier, r);
    const auto integral = surface_integral(patches_of(pose), 1000, 600, kAtCarrier, r);
    CHECK(std::abs(model - integral) < 0.01 * broadside);
  }
}

// Protects the profile in range: a smooth oblique plate echoes from its edges, and parts too long
// in range make it echo from its middle. Energy of the error over the band, with the Gaussian
// pulse, against that of the echo: 0.4 % at most; 5 % are 13 dB below the edges.
TEST_CASE("an oblique plate is its surface integral over the band", "[figure]") {
  const Sonar sonar = sonar_of(64, 40, radians(11), radians(7));
  for (const double turn : {10.0, 20.0, 50.0}) {
    INFO(turn);
    const Pose pose{{5, 0, 0}, from_roll_pitch_yaw(0, 0, radians(turn))};
    const BoxShape plate{{1e-7, 0.15, 0.08}, false};
    const auto echoes = echoes_of(mirror_world(plate, pose), sonar);
    double error = 0, energy = 0;
    for (int i = -3; i <= 3; ++i) {
      const double f = kAtCarrier + i / 8.0 * sonar.bandwidth_hz;
      const double spectrum = std::exp(-std::pow(kPi * i / 8.0, 2));
      const auto integral = surface_integral({front_of(pose, plate)}, 3000, 120, f, 5);
      error += std::norm(spectrum * (sum_of_echoes(echoes, f, 5) - integral));
      energy += std::norm(spectrum * integral);
    }
    CHECK(error < 0.05 * energy);
  }
}

// Protects the record: no random part, fixed order and identities whatever the workers, and
// nothing from surfaces that are no mirrors.
TEST_CASE("coherent scatterers do not depend on threads") {
  World world = mirror_world(SphereShape{0.05, false}, {{2, 0, 0}, {}});
  Material diffuse;
  diffuse.reflectivity = 1;
  add_object(world, SphereShape{5, true}, {}, diffuse);
  const Sonar sonar = sonar_of(64, 20, radians(20), radians(6));
  const auto one = echoes_of(world, sonar, 1), four = echoes_of(world, sonar, 4);
  REQUIRE(one.size() == four.size());
  REQUIRE(one.size() > 1000);
  std::set<std::uint64_t> keys;
  for (std::size_t i = 0; i < one.size(); ++i) {
    REQUIRE(one[i].key == four[i].key);
    REQUIRE(one[i].delay_s == four[i].delay_s);
    REQUIRE(one[i].mean == four[i].mean);
    REQUIRE(one[i].standard_deviation == 0);
    REQUIRE(one[i].instance == 1);
    REQUIRE(sector_of(sonar, one[i].arrival.azimuth_rad) == static_cast<int>(one[i].beam));
    REQUIRE(one[i].key >> 62 == 1);
    keys.insert(one[i].key);
  }
  CHECK(keys.size() == one.size());
}

TEST_CASE("coherent echoes keep to the sonar's ranges") {
  const World plate = mirror_world(BoxShape{{0.01, 0.5, 0.5}, false}, {{5.01, 0, 0}, {}});
  Sonar sonar = sonar_of(16, 16, radians(16), radians(16));
  for (const Scatterer& s : echoes_of(plate, sonar)) REQUIRE(s.delay_s >= 10 / kSoundSpeed_m_s);
  sonar.range_min_m = 5.02;
  const auto beyond = echoes_of(plate, sonar);
  REQUIRE_FALSE(beyond.empty());
  for (const Scatterer& s : beyond) REQUIRE(length(s.position_m) >= 5.02);
  sonar.range_max_m = 4.9;
  sonar.range_min_m = 0;
  CHECK(echoes_of(plate, sonar).empty());
}

// Protects coarse meshes of round bodies: over attitude, their levels stay within 0.3 dB of those
// of the bodies. The facets themselves swing by tens of dB.
TEST_CASE("curved meshes echo as the bodies that they stand for", "[figure]") {
  const Sonar sonar = sonar_of(64, 40, radians(11), radians(7));
  const double wavelength_m = kSoundSpeed_m_s / kAtCarrier;
  const auto level_db = [&](const Shape& shape, const Pose& pose, double reference_m) {
    return 20 * std::log10(std::abs(sum_of_echoes(echoes_of(mirror_world(shape, pose), sonar),
                                                  kAtCarrier, reference_m)));
  };
  const auto curved = [&](const Mesh& mesh) {
    return MeshShape{std::make_shared<const Mesh>(*curved_mesh(mesh, wavelength_m))};
  };
  const double radius_m = 0.2, range_m = 3;
  const auto at = [&](Quat turn) { return Pose{{range_m + radius_m, 0, 0}, turn}; };
  const double sphere_db = level_db(SphereShape{radius_m, false}, at({}), range_m);
  const MeshShape ball = curved(test::ball_mesh(radius_m));
  const MeshShape flat_ball{std::make_shared<const Mesh>(test::ball_mesh(radius_m))};
  double worst_flat_db = 0;
  for (const double turn : {0.0, 0.1, 0.25, 0.6, 1.1}) {
    INFO(turn);
    const Pose pose = at(from_roll_pitch_yaw(turn, 2 * turn, -turn));
    CHECK(level_db(ball, pose, range_m) == Approx(sphere_db).margin(0.3));
    worst_flat_db =
        std::max(worst_flat_db, std::abs(level_db(flat_ball, pose, range_m) - sphere_db));
  }
  CHECK(worst_flat_db > 10);
  const double cylinder_db = level_db(CylinderShape{radius_m, 0.1}, at({}), range_m);
  const MeshShape prism = curved(test::prism_mesh(radius_m, 0.2, 24, true));
  for (const double yaw_deg : {0.0, 3.0, 7.5, 9.0}) {
    INFO(yaw_deg);
    CHECK(level_db(prism, at(from_roll_pitch_yaw(0, 0, radians(yaw_deg))), range_m) ==
          Approx(cylinder_db).margin(0.3));
  }
}
