#include "trace/refracted.h"

#include <cmath>

#include "acoustics/pattern.h"
#include "catch.h"
#include "crowded_world.h"
#include "sonar_fixture.h"
#include "trace/scatter.h"

using namespace ensonify;

namespace {

constexpr double kGradient = 0.5;  // 1/s

Sonar upward_sonar(double range_max_m) {
  Sonar sonar = test::fan_sonar(16, radians(120), range_max_m, 12, radians(40));
  sonar.elevation_width_rad = radians(40);
  return sonar;
}

// c = 1500 + g z down to -400 m.
Water one_gradient(double gradient_s) {
  Water water{1490, 0.05};
  water.profile = SoundProfile{0, {-400, 400}, {1500 + 400 * gradient_s, 1500 - 400 * gradient_s}};
  return water;
}

// The same water for every practical purpose, in sheets of 2 cm that keep chords short.
Water sheets() {
  Water water{1500, 0.05};
  water.profile = SoundProfile{0, {}, {}};
  for (int i = -1500; i <= 1500; ++i) {
    water.profile->depth_m.push_back(0.02 * i);
    water.profile->speed_m_s.push_back(1500 + (i % 2 == 0 ? 1e-7 : 0));
  }
  return water;
}

// Where and when a ray that starts at sin(phi) comes to a speed on its way, by way of angles alone.
struct Arrival {
  double x_m, time_s;
};
Arrival arrival(double sine, double speed_m_s, double gradient_s, double end_speed_m_s) {
  const double p = std::sqrt(1 - sine * sine) / speed_m_s;
  const double end = -std::sqrt(1 - std::pow(p * end_speed_m_s, 2));
  return {(sine - end) / (gradient_s * p), (std::atanh(sine) - std::atanh(end)) / gradient_s};
}

}  // namespace

// Protects place and time of every echo: a level floor, met where the floor's own equations say.
TEST_CASE("refracted rays meet a floor at the place and time of the closed forms") {
  const World world = world_of({{PlaneShape{}, {{0, 0, -20}, {}}}});
  const Tracer tracer(world);
  const Sonar sonar = upward_sonar(120);
  const Pose pose{{3, -2, -4}, from_roll_pitch_yaw(0.1, 0.4, 0.8)};
  const Fan fan = make_fan(sonar);
  for (const double gradient : {kGradient, -kGradient, 8.0}) {
    const Water water = one_gradient(gradient);
    const FanHits found = trace_fan(tracer, fan, pose, sonar, water, Workers(2));
    int met = 0;
    for (std::size_t ray = 0; ray < fan.size(); ++ray) {
      const Vec3 d =
          rotate(pose.rotation, unit_vector(fan.azimuth_rad[ray / fan.rays_elevation],
                                            fan.elevation_rad[ray % fan.rays_elevation]));
      const double speed = 1500 + gradient * -4, end_speed = 1500 + gradient * -20;
      const Arrival expected = arrival(d.z, speed, gradient, end_speed);
      INFO(gradient << " " << ray);
      // A ray that turns before the floor has a root of something negative.
      const bool comes = expected.time_s > 0 && expected.time_s * 1490 <= 120;
      REQUIRE((found.hits[ray].instance != 0) == comes);
      if (!comes) continue;
      ++met;
      const RayPath& path = found.paths[ray];
      const Vec3 at = transform_point(pose, path.position_m);
      CHECK(at.z == Approx(-20).margin(1e-9));
      CHECK(std::hypot(at.x - 3, at.y + 2) == Approx(expected.x_m).epsilon(1e-9));
      CHECK(found.hits[ray].range_m == Approx(1490 * expected.time_s).epsilon(1e-9));
      const double level = std::sqrt(1 - d.z * d.z);
      const double sine = std::sqrt(1 - std::pow(level * end_speed / speed, 2));
      CHECK(found.hits[ray].cos_incidence == Approx(sine).epsilon(1e-6));
      // One gradient: tubes are those of a sphere of rays.
      const double lateral = expected.x_m / level;
      CHECK(path.curvature_radius_m == Approx(lateral).epsilon(1e-9));
      CHECK(path.tube_area_m2 == Approx(lateral * lateral).epsilon(1e-9));
      CHECK(path.spreading_m2 == Approx(speed / end_speed * lateral * lateral).epsilon(1e-9));
    }
    CHECK(met > 100);
  }
}

// Protects against leaks: chords end in the middle of nowhere, and a closed wall must hold.
TEST_CASE("no refracted ray leaves a closed room, and each ends on its wall") {
  const World world = world_of({{SphereShape{15, true}, {{1, 2, -30}, {}}}});
  const Tracer tracer(world);
  Sonar sonar = upward_sonar(60);
  sonar.beam_count = 90;
  sonar.beam_spacing_rad = radians(2);
  sonar.rays_elevation = 60;
  sonar.elevation_fan_rad = radians(170);
  const Fan fan = make_fan(sonar);
  const Pose pose{{3, -2, -28}, from_roll_pitch_yaw(0, 0, 1)};
  const FanHits found = trace_fan(tracer, fan, pose, sonar, one_gradient(25), Workers(2));
  for (std::size_t ray = 0; ray < fan.size(); ++ray) {
    REQUIRE(found.hits[ray].instance == 1);
    const Vec3 at = transform_point(pose, found.paths[ray].position_m);
    // A tenth of a millimetre squared over the diameter, and more where the ray grazes.
    const double grazing = found.hits[ray].cos_incidence;
    CHECK(std::abs(length(at - Vec3{1, 2, -30}) - 15) < 1e-8 / 30 / (grazing * grazing) + 1e-10);
  }
}

// Protects the chords themselves, against the rays that they stand for: in water that hardly bends
// them they meet what straight rays meet, behind as well.
TEST_CASE("cut into chords, straight rays meet the same things") {
  const World world = crowded_world({0, 0, 0});
  const Tracer tracer(world);
  Sonar sonar = upward_sonar(40);
  sonar.beam_count = 32;
  sonar.beam_spacing_rad = radians(120) / 32;
  const Fan fan = make_fan(sonar);
  const Pose pose{{0, 0, 0}, from_roll_pitch_yaw(0.2, 0.1, 0.1)};
  const Workers workers(2);
  const auto straight = tracer.trace_fan(fan, pose, 40, workers);
  const auto straight_behind = tracer.trace_behind(fan, straight, pose, 40, workers);
  const Water water = sheets();
  const FanHits refracted = trace_fan(tracer, fan, pose, sonar, water, workers);
  const FanHitsBehind behind =
      trace_behind(tracer, fan, refracted.hits, pose, sonar, water, workers);
  int others = 0;
  for (std::size_t ray = 0; ray < fan.size(); ++ray) {
    const Hit &a = refracted.hits[ray], &b = straight[ray];
    const auto hits = behind.behind.of_ray(ray), straight_hits = straight_behind.of_ray(ray);
    // A ray at an edge may go either way.
    if (a.instance != b.instance || hits.size() != straight_hits.size()) {
      ++others;
      continue;
    }
    if (a.instance == 0) continue;
    CHECK(a.range_m == Approx(b.range_m).epsilon(1e-6));
    CHECK(a.cos_incidence == Approx(b.cos_incidence).margin(1e-6));
    CHECK(a.reflectivity == Approx(b.reflectivity).margin(1e-4));
    for (std::size_t i = 0; i < hits.size(); ++i) {
      CHECK(hits[i].instance == straight_hits[i].instance);
      CHECK(hits[i].range_m == Approx(straight_hits[i].range_m).epsilon(1e-6));
    }
  }
  CHECK(others <= 4);
  CHECK(behind.behind.hits.size() > 100);
  CHECK(behind.paths.size() == behind.behind.hits.size());
}

// Protects data sets that name the speed that the instrument takes: nothing changes, to the bit.
TEST_CASE("a profile of the instrument's own speed is no profile") {
  const World world = crowded_world({0, 0, 0});
  const Tracer tracer(world);
  const Sonar sonar = upward_sonar(40);
  const Fan fan = make_fan(sonar);
  Water water{1490, 0.05};
  water.profile = SoundProfile{0, {0, 10}, {1490, 1490}};
  const FanHits found = trace_fan(tracer, fan, {}, sonar, water, Workers(2));
  const auto straight = tracer.trace_fan(fan, {}, 40, Workers(2));
  CHECK(found.paths.empty());
  for (std::size_t ray = 0; ray < fan.size(); ++ray) {
    CHECK(found.hits[ray].instance == straight[ray].instance);
    CHECK(found.hits[ray].range_m == straight[ray].range_m);
  }
}

// Protects the range axis: the instrument hears as far as its record is long.
TEST_CASE("what is heard ends with the instrument's range") {
  const World world = world_of({{BoxShape{{0.1, 50, 50}, false}, {{10.1, 0, 0}, {}}}});
  const Tracer tracer(world);
  Water water{1500, 0};
  water.profile = SoundProfile{0, {0}, {1600}};
  const Fan fan = make_fan(upward_sonar(9));
  const auto heard = [&](double range_max_m) {
    int count = 0;
    const FanHits found = trace_fan(tracer, fan, {}, upward_sonar(range_max_m), water, Workers(1));
    for (const Hit& hit : found.hits) count += hit.instance != 0 && hit.range_m <= range_max_m;
    for (const Hit& hit : found.hits) CHECK((hit.instance == 0 || hit.range_m <= range_max_m));
    return count;
  };
  // 10 m at 1600 m/s look like 9.375 m.
  CHECK(heard(9.37) == 0);
  CHECK(heard(9.6) > 0);
}

TEST_CASE("refracted rays do not depend on threads") {
  const World world = crowded_world({0, 0, 0});
  const Tracer tracer(world);
  const Sonar sonar = upward_sonar(40);
  const Fan fan = make_fan(sonar);
  const Water water = one_gradient(3);
  const FanHits one = trace_fan(tracer, fan, {}, sonar, water, Workers(1));
  const FanHits four = trace_fan(tracer, fan, {}, sonar, water, Workers(4));
  const auto b1 = trace_behind(tracer, fan, one.hits, {}, sonar, water, Workers(1));
  const auto b4 = trace_behind(tracer, fan, one.hits, {}, sonar, water, Workers(4));
  CHECK(b1.behind.offset == b4.behind.offset);
  REQUIRE(b1.paths.size() == b4.paths.size());
  for (std::size_t i = 0; i < b1.paths.size(); ++i) {
    CHECK(b1.behind.hits[i].range_m == b4.behind.hits[i].range_m);
    CHECK(b1.paths[i].position_m == b4.paths[i].position_m);
  }
  for (std::size_t ray = 0; ray < fan.size(); ++ray) {
    CHECK(one.hits[ray].range_m == four.hits[ray].range_m);
    CHECK(one.paths[ray].spreading_m2 == four.paths[ray].spreading_m2);
  }
}

// Protects the level of surfaces: energy of the tube, gain of the way, delay of the time.
TEST_CASE("a refracted ray's scatterer is that of the formulas") {
  const World world = world_of({{PlaneShape{}, {{0, 0, -8}, {}}}});
  const Tracer tracer(world);
  const Sonar sonar = upward_sonar(60);
  const Fan fan = make_fan(sonar);
  const Water water = one_gradient(2);
  const Pose pose{{0, 0, -1}, from_roll_pitch_yaw(0, 0.6, 0)};
  const FanHits found = trace_fan(tracer, fan, pose, sonar, water, Workers(1));
  Material floor;
  floor.reflectivity = 1e-3;
  floor.law = Lambert{1};
  const ScattererList list =
      surface_scatterer_list(fan, found.hits, {sonar, water, {{}, floor}}, Workers(2), found.paths);
  REQUIRE(list.size() > 100);
  for (const Scatterer& s : list.items) {
    const Hit& hit = found.hits[s.key];
    const RayPath& path = found.paths[s.key];
    const std::size_t e = s.key % fan.rays_elevation;
    CHECK(s.delay_s == Approx(2 * hit.range_m / 1490).epsilon(1e-14));
    CHECK(s.position_m == path.position_m);
    CHECK(s.received_path_m == Approx(path.curvature_radius_m).epsilon(1e-6));
    const double area = path.tube_area_m2 * fan.solid_angle_sr[e];
    CHECK(s.standard_deviation * s.standard_deviation ==
          Approx(1e-3 * hit.cos_incidence * area).epsilon(1e-5));
    const double gain = std::pow(10, -0.05 * 2 * path.length_m / 20) / path.spreading_m2 *
                        line_pattern(fan.elevation_rad[e], sonar.elevation_width_rad);
    CHECK(s.gain == Approx(gain).epsilon(1e-5));
  }
}

// Protects shadows of targets: what counts is the way that sound goes.
TEST_CASE("a target is hidden by what stands on its refracted path, not on the straight one") {
  // Slower upwards: the ray sags. From 0 to 12 m it lies up to 12^2 p g/8 below the straight one.
  const double gradient = -20, sag = 12.0 * 12 / 8 * 20 / 1500;
  const auto target = [&](double plate_z) {
    World world = world_of({{BoxShape{{0.1, 1, 0.05}, false}, {{6, 0, plate_z}, {}}}});
    world.point_targets.push_back({2, {12, 0, 0}, -40});
    world.instances.push_back({});
    const Tracer tracer(world);
    std::vector<HiddenTarget> hidden;
    const auto heard = point_target_scatterers(world, tracer, {}, upward_sonar(20),
                                               one_gradient(gradient), &hidden);
    CHECK(heard.size() + hidden.size() == 1);
    if (!hidden.empty()) CHECK(hidden[0].occluder == 1);
    return heard.size() == 1;
  };
  CHECK(sag > 0.2);
  CHECK(target(0));
  CHECK_FALSE(target(-sag));
  CHECK(target(sag));
}

TEST_CASE("a target on a floor is not hidden by the floor") {
  World world = world_of({{PlaneShape{}, {{0, 0, -3}, {}}}});
  world.point_targets.push_back({2, {9, 1, -3}, -40});
  world.instances.push_back({});
  const Tracer tracer(world);
  CHECK(point_target_scatterers(world, tracer, {}, upward_sonar(20), one_gradient(3)).size() == 1);
}
