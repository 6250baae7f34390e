#include "trace/scatter.h"

#include <cmath>
#include <limits>

#include "acoustics/pattern.h"
#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "synthesis/backend.h"
#include "trace/plain_world.h"

using namespace ensonify;

namespace {

Sonar sixteen_beams() {
  Sonar sonar = test::fan_sonar(16, radians(16), 8, 8);
  sonar.range_min_m = 0.5;
  return sonar;
}

Material lambertian(double reflectivity, double lambert_exponent) {
  Material material;
  material.reflectivity = reflectivity;
  material.law = Lambert{lambert_exponent};
  return material;
}

std::vector<Hit> wall_hits(const Fan& fan) {
  return std::vector<Hit>(fan.size(), Hit{5.0, 0.8f, 1});
}

}  // namespace

TEST_CASE("a hit becomes the scatterer of the formulas") {
  const Sonar sonar = sixteen_beams();
  const Fan fan = make_fan(sonar);
  const auto scatterers =
      surface_scatterers(fan, wall_hits(fan), {sonar, kWater, {{}, lambertian(1e-3, 2)}});
  REQUIRE(scatterers.size() == fan.size());
  const std::size_t ray = ray_index(fan, 3, 0, 5);
  const Scatterer& s = scatterers[ray];
  CHECK(s.key == ray);
  CHECK(s.beam == 3);
  CHECK(s.delay_s == Approx(10.0 / 1500));
  CHECK(s.arrival.azimuth_rad == Approx(beam_azimuth_rad(sonar, 3)));
  const double elevation = fan.elevation_rad[5];
  CHECK(s.arrival.elevation_rad == Approx(elevation));
  CHECK(s.standard_deviation == Approx(std::sqrt(1e-3 * 0.8 * 0.8 * 25 * radians(1) *
                                                 (std::sin(radians(5)) - std::sin(radians(2.5))))));
  CHECK(s.gain == Approx(1 / 25.0 * std::pow(10, -0.3 * 10 / 20) *
                         sinc(0.884 * std::sin(elevation) / radians(20))));
  CHECK(length(s.position_m) == Approx(5));
}

TEST_CASE("the reflectivity of a mesh scales the material's") {
  const Sonar sonar = sixteen_beams();
  const Fan fan = make_fan(sonar);
  std::vector<Hit> hits = wall_hits(fan);
  hits[1].reflectivity = 0.25f;
  hits[2].reflectivity = 0;
  const auto scatterers = surface_scatterers(fan, hits, {sonar, kWater, {{}, lambertian(1e-3, 1)}});
  REQUIRE(scatterers.size() == fan.size() - 1);
  CHECK(scatterers[1].standard_deviation ==
        Approx(0.5 *
               surface_scatterers(fan, wall_hits(fan), {sonar, kWater, {{}, lambertian(1e-3, 1)}})[1]
                   .standard_deviation));
}

// Protects echoes that are all mean: as K grows the random part goes to nothing, the scatterer
// stays.
TEST_CASE("a scatterer without a random part is kept") {
  const Sonar sonar = sixteen_beams();
  const Fan fan = make_fan(sonar);
  const auto random =
      surface_scatterers(fan, wall_hits(fan), {sonar, kWater, {{}, lambertian(1e-3, 1)}});
  Material constant = lambertian(1e-3, 1);
  constant.coherent = CoherentModel::rician;
  constant.rician_k = 1e300;
  const auto scatterers = surface_scatterers(fan, wall_hits(fan), {sonar, kWater, {{}, constant}});
  REQUIRE(scatterers.size() == fan.size());
  CHECK(scatterers[0].standard_deviation == 0);
  CHECK(scatterers[0].mean.real() == Approx(random[0].standard_deviation));
}

// Protects every beam from one bad ray: a miss, a hit at zero range, NaN and infinite ranges and
// incidences are left out alone, and the beams they are not in keep every bit of their series.
TEST_CASE("bad rays poison nobody") {
  const Sonar sonar = sixteen_beams();
  const Fan fan = make_fan(sonar);
  const SurfaceScattering scattering{sonar, kWater, {{}, lambertian(1e-3, 1)}};
  const std::vector<Hit> good = wall_hits(fan);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Hit bad = GENERATE_COPY(Hit{}, Hit{0, 1, 1}, Hit{nan, 1, 1},
                                Hit{5, std::numeric_limits<float>::quiet_NaN(), 1},
                                Hit{std::numeric_limits<double>::infinity(), 1, 1}, Hit{-3, 1, 1},
                                Hit{5, 1.5f, 1}, Hit{0.4, 1, 1}, Hit{8.1, 1, 1});
  std::vector<Hit> spoiled = good;
  spoiled[ray_index(fan, 7, 0, 2)] = bad;
  const auto scatterers = surface_scatterers(fan, spoiled, scattering);
  CHECK(scatterers.size() == good.size() - 1);

  const Record record = make_record(sonar, kWater, 0);
  const auto backend = make_cpu_backend({sonar, kWater, record});
  const auto series_of = [&](std::vector<Scatterer> list) {
    const ScattererList sorted = sorted_by_beam_and_delay(std::move(list), 16);
    const PingTask task{&sorted, RandomKeys{1, 0, 0, 0, 0}, 0, {}};
    PingSeries series;
    backend->synthesize({&task, 1}, {&series, 1}, Workers(1));
    return series;
  };
  std::vector<Scatterer> expected = surface_scatterers(fan, good, scattering);
  expected.erase(expected.begin() + static_cast<std::ptrdiff_t>(ray_index(fan, 7, 0, 2)));
  const PingSeries a = series_of(scatterers), b = series_of(expected);
  for (std::size_t i = 0; i < a.pressure_pa.size(); ++i) {
    REQUIRE(std::isfinite(a.pressure_pa[i].real()));
    REQUIRE(a.pressure_pa[i] == b.pressure_pa[i]);
    REQUIRE(a.clean_power_pa2[i] == b.clean_power_pa2[i]);
  }
}

// Protects the list that is made at once: the same scatterers as one by one, sorted; for any number
// of threads, with several columns a sector, with rays left out and with hits that make no echo.
TEST_CASE("the list of surface scatterers is the sorted scatterers") {
  Sonar sonar = sixteen_beams();
  sonar.transmit_width_rad = radians(30);
  sonar.rays_azimuth = GENERATE(1, 3);
  sonar.rays_elevation = GENERATE(1, 40);
  const Fan fan = make_fan(sonar);
  Material constant = lambertian(2e-3, 2);
  constant.coherent = CoherentModel::rician;
  constant.rician_k = 3;
  const SurfaceScattering scattering{sonar, kWater, {{}, lambertian(1e-3, 1), constant}};
  std::vector<Hit> hits(fan.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const auto draw = [&](unsigned k) { return uniform(3, 0, i, k); };
    // From within and without the ranges, in steps so that some are alike.
    hits[i] = {0.125 * static_cast<int>(80 * draw(0)),
               static_cast<float>(draw(1)),
               static_cast<std::uint32_t>(3 * draw(2)),
               1,
               {}};
    if (draw(3) < 0.1) hits[i].reflectivity = 0;
    if (draw(4) < 0.1) hits[i].cos_incidence = std::numeric_limits<float>::quiet_NaN();
  }
  const ScattererList expected =
      sorted_by_beam_and_delay(surface_scatterers(fan, hits, scattering), sonar.beam_count);
  CHECK(expected.size() < 0.6 * static_cast<double>(hits.size()));
  CHECK(expected.size() > 0);
  for (const int threads : {1, 3}) {
    const ScattererList list = surface_scatterer_list(fan, hits, scattering, Workers(threads));
    REQUIRE(list.beam_offset == expected.beam_offset);
    REQUIRE(list.size() == expected.size());
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Scatterer &a = list.items[i], &b = expected.items[i];
      REQUIRE(a.key == b.key);
      REQUIRE(a.delay_s == b.delay_s);
      REQUIRE(a.position_m == b.position_m);
      REQUIRE(a.arrival.azimuth_rad == b.arrival.azimuth_rad);
      REQUIRE(a.departure.elevation_rad == b.departure.elevation_rad);
      REQUIRE(a.gain == b.gain);
      REQUIRE(a.mean == b.mean);
      REQUIRE(a.standard_deviation == b.standard_deviation);
      REQUIRE(a.cos_incidence == b.cos_incidence);
      REQUIRE(a.beam == b.beam);
      REQUIRE(a.instance == b.instance);
    }
  }
}

// Protects point targets: behind a wall, outside the fan and outside the ranges they are silent.
TEST_CASE("point targets are hidden by what stands before them") {
  World world = world_with(BoxShape{{0.1, 1, 1}, false}, {{3, 0, 0}, {}});
  world.instances.resize(7);
  const auto add = [&](std::uint32_t id, Vec3 p) { world.point_targets.push_back({id, p, -20}); };
  add(2, {5, 0, 0});                                  // behind the box
  add(3, {2, 0, 0});                                  // before it
  add(4, {2.9, 0, 0});                                // on its face
  add(5, {2 * std::cos(0.3), 2 * std::sin(0.3), 0});  // beside the fan
  add(6, {2, 0, 1});                                  // above it
  add(7, {0.4, 0, 0});                                // too near
  const Tracer tracer(world);
  const auto scatterers = point_target_scatterers(world, tracer, {}, sixteen_beams(), kWater);
  REQUIRE(scatterers.size() == 2);
  CHECK(scatterers[0].instance == 3);
  CHECK(scatterers[1].instance == 4);
  CHECK(scatterers[0].mean.real() == Approx(0.1));
  CHECK(scatterers[0].standard_deviation == 0);
  // The world turned and moved with the sonar changes nothing.
  const Pose moved{{10, -5, 2}, from_roll_pitch_yaw(0.2, 0.3, 2.0)};
  World other = world;
  other.objects[0].pose = compose(moved, world.objects[0].pose);
  for (PointTarget& t : other.point_targets) t.position_m = transform_point(moved, t.position_m);
  const Tracer again(other);
  const auto same = point_target_scatterers(other, again, moved, sixteen_beams(), kWater);
  REQUIRE(same.size() == 2);
  CHECK(same[0].delay_s == Approx(scatterers[0].delay_s).epsilon(1e-12));
}
