// Materials by part of a mesh: from the file to the scatterers.
#include <cmath>
#include <complex>

#include "catch.h"
#include "core/units.h"
#include "scenario/scenario.h"
#include "sonar_fixture.h"
#include "temporary_folder.h"
#include "trace/plain_world.h"
#include "trace/scatter.h"

using namespace ensonify;

namespace {

constexpr double kSoundSpeed = 1500;

Sonar fan_of_parts(int beams, int rays, double fov_rad, double fan_rad) {
  return test::fan_sonar(beams, fov_rad, 12, rays, fan_rad);
}

// A wall across the boresight, its halves to port (y > 0) and to starboard.
constexpr char kPort[] = "v 0 0 -1\nv 0 1 -1\nv 0 1 1\nv 0 0 1\ng port\nf 1 2 3 4\n";
constexpr char kStarboard[] = "v 0 -1 -1\nv 0 0 -1\nv 0 0 1\nv 0 -1 1\ng starboard\n";

std::string wall() { return std::string(kPort) + kStarboard + "f 5 6 7 8\n"; }
std::string starboard_alone() { return std::string(kStarboard) + "f 1 2 3 4\n"; }

MaterialSpec material(const char* name, double reflectivity, CoherentSpec coherent = {}) {
  return {name, reflectivity, {}, coherent};
}

// A mesh of a file, with materials of its parts.
ObjectSpec object(const char* name, const char* of, const std::filesystem::path& file,
                  std::vector<PartSpec> parts, double x_m, double scale) {
  const MeshSpec mesh{file, {scale, scale, scale}, false, false, std::move(parts)};
  PoseSpec pose;
  pose.position_m = {x_m, 0, 0};
  return {name, "x", of, mesh, pose};
}

World world_of_parts(std::vector<MaterialSpec> materials, std::vector<ObjectSpec> objects) {
  Scenario scenario;
  scenario.materials = std::move(materials);
  scenario.objects = std::move(objects);
  Result<World> world = build_world(scenario);
  INFO((world ? "" : world.error().message));
  REQUIRE(world.ok());
  return std::move(*world);
}

struct Echoes {
  std::vector<Scatterer> random, coherent;
};

Echoes echoes_of_parts(const World& world, const Sonar& sonar) {
  const Tracer tracer(world);
  const Fan fan = make_fan(sonar);
  const Workers workers(2);
  const auto hits = tracer.trace_fan(fan, {}, sonar.range_max_m, workers);
  const auto scattering = make_surface_scattering(sonar, {kSoundSpeed, 0}, world);
  return {surface_scatterers(fan, hits, scattering),
          kirchhoff_scatterers(fan, hits, tracer, {}, scattering, workers)};
}

double energy(const std::vector<Scatterer>& scatterers, bool port) {
  double sum = 0;
  for (const Scatterer& s : scatterers) {
    if ((s.position_m.y > 0) != port) continue;
    sum += (std::norm(std::complex<double>(s.mean)) + std::pow(double(s.standard_deviation), 2)) *
           std::pow(double(s.gain), 2);
  }
  return sum;
}

// What the mirrors of a world add up to; the pattern is that of the widest fan.
std::complex<double> coherent_sum(const World& world, const Sonar& sonar, double reference_m) {
  return sum_of_echoes(echoes_of_parts(world, sonar).coherent, sonar.frequency_hz, reference_m,
                       radians(1e6));
}

}  // namespace

// Protects the levels: the fan is symmetric, so the halves differ by their materials alone, in the
// random part as in the rician one.
TEST_CASE("halves of a mesh echo in the ratio of their reflectivities") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("wall.obj", wall());
  const Sonar sonar = fan_of_parts(16, 8, radians(10), radians(10));
  const bool rician = GENERATE(false, true);
  const CoherentSpec coherent = rician ? CoherentSpec(RicianSpec{0.7}) : CoherentSpec();
  const World world =
      world_of_parts({material("a", 1e-3, coherent), material("b", 2.5e-2, coherent)},
                     {object("w", "a", file, {{"starboard", "b"}}, 5, 1)});
  const auto echoes = echoes_of_parts(world, sonar).random;
  REQUIRE(echoes.size() == 128);
  CHECK(energy(echoes, false) / energy(echoes, true) == Approx(25).epsilon(1e-6));
  for (const Scatterer& s : echoes) REQUIRE(s.instance == 1);
}

// Protects what follows the triangle: the same wall from two files of one part each has the same
// scatterers, but for the instance.
TEST_CASE("a mesh of two parts scatters as two meshes") {
  const test::TemporaryFolder folder;
  const auto whole = folder.write("wall.obj", wall());
  const auto port = folder.write("port.obj", kPort);
  const auto starboard = folder.write("starboard.obj", starboard_alone());
  const Sonar sonar = fan_of_parts(33, 21, radians(40), radians(20));
  const std::vector<MaterialSpec> materials{material("a", 1e-3), material("b", 2e-2, RicianSpec{2}),
                                            material("c", 0)};
  const World parts = world_of_parts(
      materials, {object("w", "c", whole, {{"starboard", "b"}, {"port", "a"}}, 5, 2)});
  const World apart = world_of_parts(
      materials, {object("p", "a", port, {}, 5, 2), object("s", "b", starboard, {}, 5, 2)});
  const auto one = echoes_of_parts(parts, sonar).random;
  const auto two = echoes_of_parts(apart, sonar).random;
  REQUIRE(one.size() == two.size());
  REQUIRE(one.size() > 500);
  for (std::size_t i = 0; i < one.size(); ++i) {
    // The middle column meets the seam, which either half owns.
    if (std::abs(one[i].position_m.y) < 1e-6) continue;
    REQUIRE(one[i].delay_s == two[i].delay_s);
    REQUIRE(one[i].standard_deviation == two[i].standard_deviation);
    REQUIRE(one[i].mean == two[i].mean);
  }
}

// Protects coherent parts: the mirror ends where its material does. The seam is an edge of half the
// wall; the sums differ from those of two meshes by what the bend is told from, under 1 % (-40 dB).
TEST_CASE("a mirror that is a part of a mesh is that part alone") {
  const test::TemporaryFolder folder;
  const auto whole = folder.write("wall.obj", wall());
  const auto port = folder.write("port.obj", kPort);
  const auto starboard = folder.write("starboard.obj", starboard_alone());
  const Sonar sonar = fan_of_parts(40, 40, radians(2), radians(2));
  const char* other = GENERATE("dull", "soft");
  const auto sum_over = [&](std::vector<ObjectSpec> objects) {
    return coherent_sum(
        world_of_parts({material("dull", 1e-3), material("mirror", 1e-3, KirchhoffSpec{1, 0}),
                        material("soft", 1e-3, KirchhoffSpec{-0.5, 0})},
                       std::move(objects)),
        sonar, 3);
  };
  const auto one = sum_over({object("w", other, whole, {{"port", "mirror"}}, 3, 0.03)});
  const auto two = sum_over(
      {object("p", "mirror", port, {}, 3, 0.03), object("s", other, starboard, {}, 3, 0.03)});
  CHECK(std::abs(one - two) < 0.01 * std::abs(two));
  const auto all = sum_over({object("w", "mirror", whole, {}, 3, 0.03)});
  const double share = std::string_view(other) == "dull" ? 0.5 : 0.5 - 0.25;
  CHECK(std::abs(one - share * all) < 0.01 * std::abs(all));
}
