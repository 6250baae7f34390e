// Protects: sound through walls. The front, the far wall and the next round trip of a shell against
// geometrical acoustics and the response of its plate; contents against the same without the shell;
// air inside; labels.
#include "trace/walls.h"

#include <cmath>
#include <complex>
#include <functional>
#include <map>

#include "catch.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "trace/bounces.h"

using namespace ensonify;

namespace {

constexpr double kShellRange_m = 3, kShellRadius_m = 0.1;
const Water kShellWater{.sound_speed_m_s = 1500, .density_kg_m3 = 1000};
const Wall kPvc{0.003, 1400, 2400, 1000, 0.02, true};
// Its response hardly depends on the angle near the normal, so that geometrical acoustics holds.
const Wall kFoil{0.0002, 7850, 5900, 3230, 0.02, true};

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
    WorldObject object{};
    object.instance = static_cast<std::uint32_t>(world.objects.size() + 1);
    object.shape = SphereShape{radius_m};
    object.pose.position_m = {kShellRange_m, 0, 0};
    object.material = material;
    world.objects.push_back(object);
  }
  world.instances.resize(world.objects.size());
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

// The rms value over the band of the specular echo of a path around a range. The gate is smooth,
// since a sharp one would be an edge.
double level_near(const std::vector<Scatterer>& echoes, double range_m, int path) {
  const Sonar sonar = shell_sonar();
  constexpr int kFrequencies = 31;
  double energy = 0;
  for (int i = 0; i < kFrequencies; ++i) {
    const double f = sonar.frequency_hz + sonar.bandwidth_hz * ((i + 0.5) / kFrequencies - 0.5);
    std::complex<double> sum = 0;
    for (const Scatterer& s : echoes) {
      if (s.path != path) continue;
      const double range = s.delay_s * kShellWater.sound_speed_m_s / 2;
      const double offset = std::abs(range - range_m) / (0.7 * kShellRadius_m);
      if (offset > 1) continue;
      // The amplitude of a specular echo is that at the carrier, and rises with the frequency.
      sum += std::pow(std::cos(kPi / 2 * offset), 2) * std::complex<double>(s.mean) *
             (double{s.gain} * f / sonar.frequency_hz) * std::polar(1.0, -2 * kPi * f * s.delay_s);
    }
    energy += std::norm(sum) / kFrequencies;
  }
  return std::sqrt(energy);
}

// The rms value over the band of what a plate does at normal incidence.
double over_band(const Wall& wall, const std::function<std::complex<double>(PlateResponse)>& part) {
  const Sonar sonar = shell_sonar();
  constexpr int kFrequencies = 400;
  double energy = 0;
  for (int i = 0; i < kFrequencies; ++i) {
    const double f = sonar.frequency_hz + sonar.bandwidth_hz * ((i + 0.5) / kFrequencies - 0.5);
    energy += std::norm(part(plate_response(wall, kShellWater, 0, f))) / kFrequencies;
  }
  return std::sqrt(energy);
}

// Geometrical acoustics on the axis: the pressure at the sonar after reflections off mirrors of
// these curvature radii (positive: concave), with the pieces in between.
double axial_pressure(std::span<const double> pieces_m, std::span<const double> radii_m) {
  double pressure = 1 / pieces_m[0], front_m = pieces_m[0];
  for (std::size_t i = 0; i < radii_m.size(); ++i) {
    front_m = 1 / (1 / front_m - 2 / radii_m[i]);
    pressure *= std::abs(front_m / (front_m + pieces_m[i + 1]));
    front_m += pieces_m[i + 1];
  }
  return pressure;
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

TEST_CASE("a shell of water answers with its front, its far wall and a train behind") {
  const auto echoes = all_echoes(balls({{kShellRadius_m, shell_material(kFoil, true)}}), 2);
  const double a = kShellRadius_m, near = kShellRange_m - a, far = kShellRange_m + a;
  const auto error_db = [&](double range_m, int path, double response, double pressure) {
    return std::abs(20 * std::log10(level_near(echoes, range_m, path) / (response * pressure)));
  };
  // The taps miss 1e-3 of the energy each time that sound meets the wall.
  const double front = over_band(kFoil, [](PlateResponse p) { return p.reflected; });
  CHECK(error_db(near, 0, front, axial_pressure(std::array{near, near}, std::array{-a})) < 0.3);
  const double once =
      over_band(kFoil, [](PlateResponse p) { return p.transmitted * p.transmitted * p.reflected; });
  CHECK(error_db(far, kThroughWalls | path_of_kinds(1, 1), once,
                 axial_pressure(std::array{far, far}, std::array{a})) < 0.3);
  const double again = over_band(kFoil, [](PlateResponse p) {
    return p.transmitted * p.transmitted * std::pow(p.reflected, 3);
  });
  CHECK(error_db(far + 2 * a, kThroughWalls | path_of_kinds(3, 7), again,
                 axial_pressure(std::array{far, 2 * a, 2 * a, far}, std::array{a, a, a})) < 0.5);
}

TEST_CASE("air inside a shell leaves its front and what rings in the wall") {
  Wall wall = kFoil;
  wall.water_inside = false;
  const auto echoes = all_echoes(balls({{kShellRadius_m, shell_material(wall, true, 0.1)}}), 2);
  const double near = kShellRange_m - kShellRadius_m;
  const double expected = over_band(wall, [](PlateResponse p) { return p.reflected; }) *
                          axial_pressure(std::array{near, near}, std::array{-kShellRadius_m});
  CHECK(std::abs(20 * std::log10(level_near(echoes, near, 0) / expected)) < 0.3);
  CHECK(energy_of(echoes, true) == 0);
  CHECK(std::ranges::none_of(echoes,
                             [](const Scatterer& s) { return (s.path & kThroughWalls) != 0; }));
}

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
