// Bounced echoes of surfaces: footprints, laws and draws.
#include "trace/multipath.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "mirrored_sea.h"
#include "synthesis/backend.h"

using namespace ensonify;
using namespace ensonify::test;

// Protects level and place of diffuse echoes over a mirror: ray by ray they are those of the
// mirrored world seen straight.
TEST_CASE("a surface shows the mirrored world") {
  const std::string objects = R"(objects:
  - {name: ball, material: sand, shape: {sphere: {radius_m: 1.2}}, pose: {position_m: [7, 1, {ball}]}}
  - {name: slab, material: sand, shape: {box: {size_m: [1, 3, 2]}}, pose: {position_m: [9, -3, {slab}], rotation_deg: [0, {pitch}, 0]}}
)";
  const auto placed = [&](double ball, double slab, double pitch) {
    std::string text = objects;
    const std::pair<const char*, double> holes[] = {
        {"{ball}", ball}, {"{slab}", slab}, {"{pitch}", pitch}};
    for (const auto& [hole, value] : holes) {
      text.replace(text.find(hole), std::string(hole).size(), fmt::format("{}", value));
    }
    return text;
  };
  const Sea sea(head(100, 180) + kMaterials + placed(0, -0.5, 20) +
                "multipath: {surface: {z_m: 3, reflection: 1}}\n");
  const Sea mirrored(head(100, 180) + kMaterials + placed(6, 6.5, -20));
  std::map<std::uint64_t, Scatterer> direct;
  for (const Scatterer& s :
       surface_scatterers(mirrored.fan, mirrored.hits(), mirrored.scattering)) {
    direct[s.key] = s;
  }
  const auto over_mirror = sea.of_path(3);
  CHECK(over_mirror.size() == direct.size());
  CHECK(direct.size() > 200);
  for (const Scatterer& s : over_mirror) {
    const auto twin = direct.find(s.key & ((std::uint64_t{1} << 40) - 1));
    REQUIRE(twin != direct.end());
    const Scatterer& d = twin->second;
    CHECK(std::abs(s.delay_s - d.delay_s) < 1e-12);
    CHECK(s.standard_deviation == Approx(d.standard_deviation).epsilon(1e-5));
    CHECK(s.gain == Approx(d.gain).epsilon(1e-5));
    CHECK(s.beam == d.beam);
    CHECK(s.instance == d.instance);
    CHECK(s.position_m.z == Approx(6 - d.position_m.z).margin(1e-9));
  }
}

// Protects the footprint, the bistatic law and both ranges of a mixed path: the sum over its rays
// is the integral over the wall, which knows of no rays.
TEST_CASE("a mixed path brings the energy of the integral over the surface") {
  const Sea sea(head(100, 400, 60) + kMaterials +
                "objects: [{name: wall, material: sand, shape: {plane: {}}, pose: {position_m: [8, "
                "0, 0], rotation_deg: [0, 90, 0]}}]\n"
                "multipath: {surface: {z_m: 3, reflection: -0.7}, bounces: 1}\n");
  double sum[2] = {};
  for (const Scatterer& s : sea.bounced()) {
    sum[s.path - 1] += std::pow(double{s.standard_deviation} * s.gain, 2);
  }
  const double fan = sea.sonar.elevation_fan_rad / 2;
  double integral[2] = {};
  const double step = 0.01;
  for (double z = -12 + step / 2; z < 3; z += step) {
    for (double y = -6 + step / 2; y < 6; y += step) {
      const Vec3 ways[] = {{8, y, z}, {8, y, 6 - z}};
      if (std::abs(elevation(ways[0])) > fan || std::abs(elevation(ways[1])) > fan ||
          std::abs(azimuth(ways[0])) > radians(30)) {
        continue;
      }
      const double strength = 1e-2 * (8 / length(ways[0])) * (8 / length(ways[1]));
      for (int path = 0; path < 2; ++path) {
        const double gain = 0.7 * 10 * target_pressure(sea.sonar, ways[path], ways[1 - path]);
        integral[path] += strength * gain * gain * step * step;
      }
    }
  }
  for (int path = 0; path < 2; ++path) {
    CAPTURE(path, sum[path], integral[path]);
    CHECK(sum[path] == Approx(integral[path]).epsilon(0.003));
  }
}

// Protects reciprocity: the way there and the way back round have one amplitude and one draw.
TEST_CASE("both ways round share delay, amplitude and key") {
  const Sea sea(head(100, 300) + kMaterials +
                "objects: [{name: ball, material: sand, shape: {sphere: {radius_m: 1}}, pose: "
                "{position_m: [7, 1, 0]}}]\nmultipath: {surface: {z_m: 3, reflection: 1}, bottom: "
                "{z_m: -4, reflection: 0.5}, bounces: 3}\n");
  std::map<std::pair<std::uint16_t, std::uint64_t>, Scatterer> by_path;
  const auto echoes = sea.bounced();
  for (const Scatterer& s : echoes) {
    CHECK(by_path.emplace(std::pair{s.path, s.key}, s).second);
  }
  std::size_t pairs = 0;
  for (const LegPair& pair : sea.plan.pairs) {
    for (const auto& [id, s] : by_path) {
      if (id.first != pair.out_first || pair.first == pair.second) continue;
      const auto twin = by_path.find({pair.out_second, id.second});
      REQUIRE(twin != by_path.end());
      ++pairs;
      CHECK(twin->second.delay_s == s.delay_s);
      CHECK(twin->second.standard_deviation == s.standard_deviation);
      CHECK(twin->second.arrival.elevation_rad == s.departure.elevation_rad);
      CHECK(twin->second.departure.elevation_rad == s.arrival.elevation_rad);
    }
  }
  CHECK(pairs > 200);
}

TEST_CASE("bounced echoes do not depend on the workers") {
  const Sea sea(head(100, 300) + kMaterials +
                "objects: [{name: ball, material: sand, shape: {sphere: {radius_m: 1}}, pose: "
                "{position_m: [7, 1, 0]}}]\nmultipath: {surface: {z_m: 3, reflection: 1}}\n");
  const auto one = sea.bounced(1), four = sea.bounced(4);
  REQUIRE(one.size() == four.size());
  REQUIRE(one.size() > 100);
  for (std::size_t i = 0; i < one.size(); ++i) {
    const bool same = one[i].key == four[i].key && one[i].path == four[i].path &&
                      one[i].delay_s == four[i].delay_s && one[i].gain == four[i].gain;
    REQUIRE(same);
  }
}

// Protects V5 for bounced echoes: the series of both ways round adds in phase.
TEST_CASE("both ways round in one sector are one echo of the series' power", "[figure]") {
  const Sea sea(
      head(100, 60) + kMaterials +
      "objects: [{name: ball, material: sand, shape: {sphere: {radius_m: 1}}, pose: "
      "{position_m: [7, 1, 0]}}]\nmultipath: {surface: {z_m: 3, reflection: -1}, bounces: "
      "1}\n");
  const auto apart = sea.bounced(), together = both_ways_as_one(sea.bounced());
  REQUIRE(together.size() == apart.size() / 2);
  for (std::size_t i = 0; i < together.size(); ++i) {
    const Scatterer &one = apart[2 * i], &other = apart[2 * i + 1];
    REQUIRE(together[i].key == one.key);
    REQUIRE(together[i].path == std::min(one.path, other.path));
    REQUIRE(together[i].gain == one.gain + other.gain);
  }
  const SynthesisSetup setup{sea.sonar, sea.water, make_record(sea.sonar, sea.water, 0)};
  const auto backend = make_cpu_backend(setup);
  const ScattererList list = sorted_by_beam_and_delay(together, sea.sonar.beam_count);
  double drawn = 0, expected = 0;
  for (std::uint32_t ping = 0; ping < 200; ++ping) {
    RandomKeys keys;
    keys.speckle = stream_key(9, Stream::speckle, 0);
    keys.speckle_ping = ping;
    const PingTask task{&list, keys, 0, {}};
    PingSeries series;
    backend->synthesize({&task, 1}, {&series, 1}, Workers(1));
    for (const std::complex<float> p : series.pressure_pa) drawn += std::norm(p);
    for (const float p : series.clean_power_pa2) expected += p;
  }
  // Some 20 independent cells each: a standard error of 2 %.
  CHECK(drawn / expected == Approx(1).epsilon(0.06));
}

TEST_CASE("both ways round in different sectors stay two echoes") {
  // A wall beside: out and back differ in azimuth.
  const Sea sea(
      head(100, 60) + kMaterials +
      "objects: [{name: wall, material: mirror, shape: {box: {size_m: [30, 1, 20]}}, pose: "
      "{position_m: [8, 4, 0]}}]\n" +
      target_at(10, -1, 0) + "multipath: {objects: true, bounces: 1}\n");
  const auto echoes = sea.bounced();
  REQUIRE(echoes.size() >= 2);
  CHECK(both_ways_as_one(echoes).size() == echoes.size());
}
