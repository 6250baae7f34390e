#include "trace/scatter.h"
// Protects: sound through walls. Contents of a shell against the same without the shell, and labels.
// The shell itself, V25, is in tests/verification/walls.py.
#include "trace/walls.h"

#include <cmath>
#include <complex>
#include <map>

#include "catch.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "trace/bounces.h"
#include "trace/plain_world.h"

using namespace ensonify;

namespace {

constexpr double kShellRange_m = 3, kShellRadius_m = 0.1;
const Water kShellWater{.sound_speed_m_s = 1500, .density_kg_m3 = 1000};
const Wall kPvc{0.003, 1400, 2400, 1000, 0.02, true};

Sonar shell_sonar() {
  Sonar sonar = test::fan_sonar(24, radians(6), 12, 96, radians(6));
  // The taps of an echo then stay near it: a cell is 5 mm long.
  sonar.frequency_hz = 750e3;
  sonar.bandwidth_hz = 150e3;
  sonar.elevation_width_rad = radians(60);
  return sonar;
}

Material shell_material(const Wall& wall, bool smooth, double reflectivity = 0) {
  Material material;
  material.reflectivity = reflectivity;
  material.wall = wall;
  material.reflection = 1;
  if (smooth) material.coherent = CoherentModel::kirchhoff;
  return material;
}

World balls(std::initializer_list<std::pair<double, Material>> given) {
  World world;
  for (const auto& [radius_m, material] : given) {
    add_object(world, SphereShape{radius_m}, {{kShellRange_m, 0, 0}, {}}, material);
  }
  return world;
}

std::vector<Scatterer> all_echoes(const World& world, int bounces) {
  const Sonar sonar = shell_sonar();
  const Tracer tracer(world);
  const Fan fan = make_fan(sonar);
  const Workers workers(2);
  const auto hits = tracer.trace_fan(fan, {}, sonar.range_max_m, workers);
  const SurfaceScattering scattering = make_surface_scattering(sonar, kShellWater, world);
  std::vector<Scatterer> all = kirchhoff_scatterers(fan, hits, tracer, {}, scattering, workers);
  for (const Scatterer& s : surface_scatterers(fan, hits, scattering)) all.push_back(s);
  for (const Scatterer& s : bounced_off_surfaces(
           {tracer, world.volumes, {}, scattering, bounces, true, 7, 0}, fan, hits, workers)) {
    all.push_back(s);
  }
  return all;
}

double energy_of(const std::vector<Scatterer>& echoes, bool through) {
  double sum = 0;
  for (const Scatterer& s : echoes) {
    if (((s.path & kThroughWalls) != 0) != through) continue;
    sum += std::norm(double{s.standard_deviation} * s.gain);
  }
  return sum;
}

// The mean energy over the band of the random echoes through walls: the taps of one echo share its
// key, and add in phase.
double heard_energy(const std::vector<Scatterer>& echoes) {
  const Sonar sonar = shell_sonar();
  std::map<std::uint64_t, std::vector<const Scatterer*>> taps;
  for (const Scatterer& s : echoes) {
    if ((s.path & kThroughWalls) != 0) taps[s.key].push_back(&s);
  }
  constexpr int kFrequencies = 31;
  double energy = 0;
  for (int i = 0; i < kFrequencies; ++i) {
    const double f = sonar.frequency_hz + sonar.bandwidth_hz * ((i + 0.5) / kFrequencies - 0.5);
    for (const auto& [key, of_echo] : taps) {
      std::complex<double> sum = 0;
      for (const Scatterer* s : of_echo) {
        sum += double{s->standard_deviation} * double{s->gain} *
               std::polar(1.0, -2 * kPi * f * s->delay_s);
      }
      energy += std::norm(sum) / kFrequencies;
    }
  }
  return energy;
}

}  // namespace

TEST_CASE("what is inside a shell echoes through its wall twice") {
  Material lambert;
  lambert.reflectivity = 0.1;
  // A small ball: all its rays meet the wall within 0.1 rad of its normal.
  const double ball_m = 0.01;
  const auto alone = all_echoes(balls({{ball_m, lambert}}), 0);
  const auto inside =
      all_echoes(balls({{kShellRadius_m, shell_material(kPvc, false)}, {ball_m, lambert}}), 0);
  const Sonar sonar = shell_sonar();
  double expected = 0;
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i) {
    const double f = sonar.frequency_hz + sonar.bandwidth_hz * ((i + 0.5) / kSteps - 0.5);
    expected += std::pow(std::abs(plate_response(kPvc, kShellWater, 0.03, f).transmitted), 4);
  }
  expected *= energy_of(alone, false) / kSteps;
  CHECK(heard_energy(inside) == Approx(expected).epsilon(0.05));
  // As the expected power counts it: taps that overlap as if they were independent.
  CHECK(energy_of(inside, true) == Approx(expected).epsilon(0.18));
  const auto labeled = [](const Scatterer& s) {
    return s.path == (kThroughWalls | path_of_kinds(1, 0)) && s.instance == 2 &&
           s.via == std::array<std::uint16_t, kMostBounces>{1, 0, 0};
  };
  CHECK(std::ranges::any_of(inside, labeled));
  CHECK(std::ranges::all_of(inside, [&](const Scatterer& s) { return s.path == 0 || labeled(s); }));
}

TEST_CASE("each path through walls is listed once") {
  const auto paths = bounce_paths(1, true);
  REQUIRE(paths.size() == 4 + 2 + 4);
  CHECK(paths[4].id == (kThroughWalls | path_of_kinds(1, 0)));
  CHECK(paths[4].out == std::vector<std::string>{"walls", "diffuse"});
  CHECK(bounce_paths(0, true).size() == 2);
  const auto echoes = all_echoes(balls({{kShellRadius_m, shell_material(kPvc, true, 0.02)}}), 1);
  CHECK(std::ranges::all_of(echoes, [&](const Scatterer& s) {
    return s.path == 0 || std::ranges::find(paths, s.path, &SoundPath::id) != paths.end();
  }));
}
