// Groups of beams that transmit in turn (sonar.transmit): when and where each is.
#include "ping/group_echoes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "catch.h"
#include "core/units.h"
#include "instrument/front_end.h"
#include "results.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// Beam j at j - 15.5 degrees.
std::string sonar_text(const std::string& transmit) {
  return R"(ensonify: 1
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 8
  beams: {count: 32, fov_deg: 32}
  rays: {elevation: 8, min_per_cell: 0}
)" + (transmit.empty() ? "" : "  transmit: {" + transmit + "}\n") +
         R"(water: {sound_speed_m_s: 1500, absorption: {fixed_db_m: 0}}
output: {cartesian: false, png: false, shadow: false, amodal: false}
motion_within_ping: true
materials: {m: {reflectivity: 1e-3}, smooth: {reflectivity: 1e-3, coherent: {model: kirchhoff}}}
)";
}

// At rest until the first groups have heard their echoes, then ahead.
const std::string kAhead =
    "trajectory: {poses: [{time_s: 0}, {time_s: 0.034}, {time_s: 1, position_m: [0.966, 0, 0]}], "
    "ping_rate_hz: 2, pings: 2}\n";
constexpr double kSound = 1500;
double x_at(double time_s) { return std::max(0.0, time_s - 0.034); }

Vec3 place_of(int beam) { return 6 * unit_vector(radians(beam - 15.5), 0); }

std::string target_at(Vec3 place) {
  return "{name: p" + std::to_string(static_cast<int>(1e6 + 1e5 * place.y)) +
         ", target_strength_db: -20, position_m: [" + std::to_string(place.x) + ", " +
         std::to_string(place.y) + ", 0]}";
}

// The delay of a place at rest from the sonar that transmits at `fired_s`.
double delay_of(Vec3 place, double fired_s) {
  const auto distance = [&](double time_s) { return length(place - Vec3{x_at(time_s), 0, 0}); };
  const double out_s = distance(fired_s) / kSound;
  double delay = 2 * out_s;
  for (int i = 0; i < 50; ++i) delay = out_s + distance(fired_s + delay) / kSound;
  return delay;
}

// All echoes of ping 0.
PingEchoes echoes_of(const Session& session) {
  const Fan fan = make_fan(session.sonar);
  const SurfaceScattering scattering =
      make_surface_scattering(session.sonar, session.water, session.world);
  const Tracer world(session.world);
  const Tracer tracer = world.at(object_poses(session, 0));
  return ping_echoes(
      {session, fan, scattering, tracer, 0, sonar_pose(session, 0), true, 7, true, 0.01},
      Workers(2));
}

}  // namespace

TEST_CASE("each group hears its targets from the pose at its own transmission") {
  std::string targets;
  for (int beam = 16; beam < 20; ++beam) {
    targets += (targets.empty() ? "" : ", ") + target_at(place_of(beam));
  }
  const SceneRun run =
      SceneRun::of_text(sonar_text("groups: 4, order: [2, 0, 3, 1], interval_s: 0.02") +
                        "point_targets: [" + targets + "]\n" + kAhead);
  REQUIRE(transmit_in_turn(run.session()));
  const PingResult ping = run.ping(0);
  REQUIRE(ping.scatterers.size() == 4);
  const std::map<std::uint32_t, double> fired_s = {{16, 0.02}, {17, 0.06}, {18, 0}, {19, 0.04}};
  for (const Scatterer& s : ping.scatterers.items) {
    CAPTURE(s.beam);
    const Vec3 place = place_of(static_cast<int>(s.beam));
    // The places have six decimals in the text.
    CHECK(s.delay_s == Approx(delay_of(place, fired_s.at(s.beam))).margin(2e-9));
    CHECK(length(s.position_m - place) < 2e-6);
  }
}

// 20 degrees a second are one beam from group to group. The target is in the cells of beams 16, 15,
// 14 and 13 as the groups fire, of which 16 belongs to group 0 and 14 to group 2.
TEST_CASE("a sonar that turns may hear a target twice") {
  const SceneRun run = SceneRun::of_text(
      sonar_text("groups: 4, interval_s: 0.05") + "point_targets: [" + target_at(place_of(16)) +
      "]\ntrajectory: {poses: [{time_s: 0}, {time_s: 1, rotation_deg: [0, 0, 20]}], ping_rate_hz: "
      "2}\n");
  std::vector<std::uint32_t> beams;
  for (const Scatterer& s : run.ping(0).scatterers.items) beams.push_back(s.beam);
  CHECK(beams == std::vector<std::uint32_t>{14, 16});
}

// The wall comes nearer by 2 cm from group to group, and while its echoes travel:
// delay = 2 r/(c + u) on the boresight, within 5e-5 of it elsewhere.
TEST_CASE("each group hears a moving wall where it is at that time") {
  const SceneRun run = SceneRun::of_text(
      sonar_text("groups: 4, interval_s: 0.02") +
      "objects: [{name: wall, material: m, shape: {box: {size_m: [1, 20, 20]}}, trajectory: "
      "{poses: [{time_s: 0, position_m: [5.5, 0, 0]}, {time_s: 1, position_m: [4.5, 0, 0]}]}}]\n");
  const PingResult ping = run.ping(0);
  std::vector<int> heard(32);
  for (const Scatterer& s : ping.scatterers.items) {
    ++heard[s.beam];
    const double wall_m = 5 - 0.02 * (s.beam % 4);
    const double range_m = wall_m / (std::cos(double{s.arrival.elevation_rad}) *
                                     std::cos(double{s.arrival.azimuth_rad}));
    REQUIRE(s.delay_s == Approx(2 * range_m / (kSound + 1)).epsilon(5e-5));
  }
  CHECK(std::ranges::count(heard, 8) == 32);
}

// Protects what is computed group by group against losing, repeating or renumbering echoes: groups
// that fire almost at once are the same as all at once.
TEST_CASE("groups that fire almost together hear what one ping hears") {
  const std::string scene =
      "objects:\n"
      "  - {name: room, material: m, pose: {position_m: [0.2, 0.3, 0.25], rotation_deg: [1, 2, "
      "3]}, "
      "shape: {box: {size_m: [13, 9, 4], inward_facing: true}}}\n"
      "  - {name: plate, material: smooth, pose: {position_m: [4, 0.2, 0.15], rotation_deg: [0, 4, "
      "3]}, shape: {box: {size_m: [0.1, 3, 3]}}}\n"
      "point_targets: [" +
      target_at(place_of(3)) + ", " + target_at(place_of(16)) +
      "]\nvolumes: [{name: water, uniform: {strength_db: -60}}]\n" + kAhead;
  const auto made = [&](const char* interval) {
    return prepared(sonar_text("groups: 8, interval_s: " + std::string(interval)) + scene);
  };
  const Session whole_session = made("0"), session = made("1e-9");
  REQUIRE(transmit_in_turn(session));
  REQUIRE_FALSE(transmit_in_turn(whole_session));
  const PingEchoes whole = echoes_of(whole_session), parts = echoes_of(session);
  const auto check_lists = [](const ScattererList& a, const ScattererList& b, bool with_keys) {
    REQUIRE(a.beam_offset == b.beam_offset);
    for (std::size_t i = 0; i < a.size(); ++i) {
      const Scatterer &s = a.items[i], &t = b.items[i];
      REQUIRE(s.beam == t.beam);
      REQUIRE(s.instance == t.instance);
      REQUIRE((!with_keys || s.standard_deviation == 0 || s.key == t.key));
      REQUIRE(s.delay_s == Approx(t.delay_s).margin(1e-11));
      REQUIRE(s.gain == Approx(t.gain).epsilon(1e-5));
      REQUIRE(length(s.position_m - t.position_m) < 1e-7);
    }
  };
  CHECK(whole.scatterers.size() > 300);
  check_lists(parts.scatterers, whole.scatterers, true);
  CHECK(whole.hidden.list.size() > 100);
  check_lists(parts.hidden.list, whole.hidden.list, false);
  CHECK(parts.hidden.occluder == whole.hidden.occluder);
  CHECK(parts.front->instance == whole.front->instance);
  CHECK(parts.volume_elevation.size() == whole.volume_elevation.size());
  REQUIRE(parts.volumes.size() == 1);
  for (std::size_t i = 0; i < whole.volumes[0].energy.size(); ++i) {
    REQUIRE(parts.volumes[0].energy[i] == Approx(whole.volumes[0].energy[i]).epsilon(1e-5));
  }
}

// Protects (18b): the level is that of the beam that hears, whoever transmitted beside it, and it
// acts on what is heard and expected, not on noise.
TEST_CASE("each group has its own level in a ping") {
  const std::string wall =
      "objects: [{name: wall, material: m, shape: {box: {size_m: [1, 20, 20]}}, pose: {position_m: "
      "[5.5, 0, 0]}}]\nnoise: {spectrum_level_db: 20}\n" +
      kAhead;
  const std::string levels = "level_db: [-1, 0, 2, 3]";
  const auto made = [&](const std::string& keys, const char* noise) {
    return SceneRun::of_text(sonar_text(keys) + wall, {{"noise.spectrum_level_db", noise}});
  };
  const SceneRun even = made("groups: 4, interval_s: 0", "20"),
                 quiet = made("groups: 4, interval_s: 0", "-100");
  const SceneRun run = made("groups: 4, interval_s: 0, level_error_db: 2, " + levels, "20");
  for (const std::uint32_t number : {0u, 1u}) {
    const std::vector<double> db =
        group_levels_db(run.session().sonar, {run.info().seed, 0, number, 0});
    REQUIRE(db[3] - db[0] != 4);
    const PingResult a = even.ping(number), b = run.ping(number), sound = quiet.ping(number);
    const std::size_t samples = a.series.size() / 32;
    double off = 0, all = 0;
    for (std::size_t i = 0; i < a.series.size(); ++i) {
      const std::size_t beam = i / samples, pixel = i % samples * 32 + beam;
      const auto p = std::complex<double>(a.series[i]),
                 heard = std::complex<double>(sound.series[i]);
      off += std::norm(std::complex<double>(b.series[i]) - p -
                       (std::pow(10.0, db[beam % 4] / 20) - 1) * heard);
      all += std::norm(p);
      if (a.polar->clean_db[pixel] < 0) continue;
      REQUIRE(b.polar->clean_db[pixel] ==
              Approx(a.polar->clean_db[pixel] + db[beam % 4]).margin(1e-3));
    }
    CHECK(std::sqrt(off / all) < 1e-5);
  }
}

// The corner of the room is straight ahead.
TEST_CASE("echoes over two surfaces leave and arrive in cells of one group") {
  const std::string scene =
      "objects: [{name: corner, material: m, pose: {rotation_deg: [0, 0, 45]}, shape: {box: "
      "{size_m: [8, 8, 4], inward_facing: true}}}]\nbounces: 1\n" +
      kAhead;
  const std::vector<Override> rays = {
      {"sonar.rays", "{elevation: 32, azimuth: 4, min_per_cell: 0}"}};
  const SceneRun alone = SceneRun::of_text(sonar_text("") + scene, rays);
  const SceneRun rest = SceneRun::of_text(sonar_text("groups: 4, interval_s: 0") + scene, rays);
  const SceneRun turn = SceneRun::of_text(sonar_text("groups: 4, interval_s: 0.02") + scene, rays);
  const auto bounced = [](const SceneRun& run, bool all_in_groups) {
    std::size_t count = 0;
    for (const Scatterer& s : run.ping(0).scatterers.items) {
      if (s.path == 0) continue;
      ++count;
      if (all_in_groups) REQUIRE(same_group_both_ways(run.session().sonar, s));
    }
    return count;
  };
  const double all = static_cast<double>(bounced(alone, false));
  REQUIRE(all > 100);
  CHECK(static_cast<double>(bounced(rest, true)) < 0.6 * all);
  CHECK(bounced(turn, false) > 0);
}

TEST_CASE("groups need no more time than there is between pings") {
  const auto session = [&](const char* interval) {
    return prepare_session(
        value_of(
            parse_scenario(sonar_text("groups: 8, interval_s: " + std::string(interval)) + kAhead,
                           "scene.yaml", ".")),
        0);
  };
  CHECK(session("0.0625"));
  const auto late = session("0.07");
  REQUIRE_FALSE(late);
  CHECK(contains(late.error().message,
                 "sonar.transmit.interval_s: 8 groups every 0.07 s need 0.56 "
                 "s, but a ping follows 0.5 s"));
}
