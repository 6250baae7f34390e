// Bounced echoes against the image method, worked out here from mirrored points.
#include "trace/multipath.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include <fmt/format.h>

#include "acoustics/pattern.h"
#include "acoustics/scattering.h"
#include "catch.h"
#include "core/units.h"

using namespace ensonify;

namespace {

constexpr double kSpeed = 1500, kAbsorption = 0.1;

std::string head(double fan_deg, int rays = 4, double fov_deg = 90) {
  return fmt::format(R"(ensonify: 1
sonar:
  frequency_hz: 3e5
  bandwidth_hz: 3e4
  source_level_db: 200
  range_max_m: 100
  beams: {{count: 30, fov_deg: {}, width_deg: 3, transmit_width_deg: 120}}
  elevation: {{width_deg: 60, fan_deg: {}}}
  rays: {{elevation: {}}}
water: {{sound_speed_m_s: {}, absorption: {{fixed_db_m: {}}}}}
)",
                     fov_deg, fan_deg, rays, kSpeed, kAbsorption);
}
const std::string kMaterials = R"(materials:
  sand: {reflectivity: 1e-2}
  mirror: {reflectivity: 0, coherent: {model: kirchhoff, reflection: 0.8, roughness_rms_m: 1e-4}}
)";

// A world at one moment, and what is heard of it over mirrors.
struct Sea {
  explicit Sea(const std::string& text) {
    auto parsed = parse_scenario(text, "sea.yaml", ".");
    if (!parsed) FAIL(parsed.error().message);
    scenario = std::move(*parsed);
    auto built = build_world(scenario);
    if (!built) FAIL(built.error().message);
    world = std::make_unique<World>(std::move(*built));
    tracer = std::make_unique<Tracer>(*world);
    sonar = sonar_of(scenario);
    water = {kSpeed, kAbsorption};
    fan = make_fan(sonar);
    scattering = make_surface_scattering(sonar, water, *world);
    auto made = make_bounce_plan(scenario);
    if (!made) FAIL(made.error().message);
    plan = std::move(*made);
    for (const WorldObject& object : world->objects) poses.push_back(object.pose);
  }
  std::vector<Hit> hits() const { return tracer->trace_fan(fan, {}, 100, Workers(1)); }
  std::vector<Scatterer> bounced(int threads = 1) const {
    return bounced_echoes({plan, *world, *tracer, poses, {}, scattering}, fan, hits(),
                          Workers(threads));
  }
  std::vector<Scatterer> of_path(std::uint16_t path) const {
    std::vector<Scatterer> found = bounced();
    std::erase_if(found, [&](const Scatterer& s) { return s.path != path; });
    return found;
  }

  Scenario scenario;
  std::unique_ptr<World> world;
  std::unique_ptr<Tracer> tracer;
  Sonar sonar;
  Water water;
  Fan fan;
  SurfaceScattering scattering;
  BouncePlan plan;
  std::vector<Pose> poses;
};

std::string target_at(double x, double y, double z) {
  return fmt::format(
      "point_targets: [{{name: p, target_strength_db: -20, position_m: [{}, {}, {}]}}]\n", x, y, z);
}

double azimuth(Vec3 p) { return std::atan2(p.y, p.x); }
double elevation(Vec3 p) { return std::asin(p.z / length(p)); }
double elevation_pattern(const Sonar& sonar, Vec3 p) {
  return line_pattern(elevation(p), sonar.elevation_width_rad);
}

// The pressure of a target of -20 dB over two images of it, without reflections.
double target_pressure(const Sonar& sonar, Vec3 out, Vec3 back) {
  const double r_out = length(out), r_back = length(back);
  return 0.1 * std::pow(10, -kAbsorption * (r_out + r_back) / 20) / (r_out * r_back) *
         std::sqrt(elevation_pattern(sonar, out) * elevation_pattern(sonar, back)) *
         transmit_pattern(azimuth(out), sonar.transmit_width_rad);
}

double pressure(const Scatterer& s) { return double{s.gain} * double{s.mean.real()}; }

const std::string kSurface = "multipath: {surface: {z_m: 3, reflection: -1}, bounces: 2}\n";
const Vec3 kTarget{10, 0.5, -1}, kImage{10, 0.5, 7};

}  // namespace

// Protects times, levels, directions and phase of the three ways under a flat surface.
TEST_CASE("a point target under a surface is heard over its image") {
  const Sea sea(head(120) + target_at(10, 0.5, -1) + kSurface);
  const auto echoes = sea.bounced();
  REQUIRE(echoes.size() == 3);
  const struct {
    std::uint16_t path;
    Vec3 out, back;
    double reflection;
  } ways[] = {{1, kTarget, kImage, -1}, {2, kImage, kTarget, -1}, {3, kImage, kImage, 1}};
  for (const auto& way : ways) {
    const auto s = std::ranges::find(echoes, way.path, &Scatterer::path);
    REQUIRE(s != echoes.end());
    CAPTURE(way.path);
    CHECK(std::abs(s->delay_s - (length(way.out) + length(way.back)) / kSpeed) < 1e-12);
    CHECK(pressure(*s) ==
          Approx(way.reflection * target_pressure(sea.sonar, way.out, way.back)).epsilon(1e-6));
    CHECK(s->departure.elevation_rad == Approx(elevation(way.out)));
    CHECK(s->departure.azimuth_rad == Approx(azimuth(way.out)));
    CHECK(s->arrival.elevation_rad == Approx(elevation(way.back)));
    CHECK(s->arrival.azimuth_rad == Approx(azimuth(way.back)));
    CHECK(s->received_path_m == Approx(length(way.back)));
    CHECK(s->beam == static_cast<std::uint32_t>(*sector_of(sea.sonar, azimuth(way.back))));
    CHECK(length(s->position_m - kTarget) < 1e-12);
    CHECK(s->instance == 1);
  }
}

TEST_CASE("paths are numbered by bounces, out and back, and named in the order of the sound") {
  const Sea sea(head(120) +
                "multipath: {surface: {z_m: 3, reflection: -1}, bottom: {z_m: -5, "
                "reflection: 0.5}, bounces: 2}\n");
  using Names = std::vector<std::string>;
  const std::vector<std::pair<Names, Names>> expected = {
      {{}, {"surface"}},           {{}, {"bottom"}},
      {{"surface"}, {}},           {{"bottom"}, {}},
      {{}, {"bottom", "surface"}}, {{}, {"surface", "bottom"}},
      {{"surface"}, {"surface"}},  {{"surface"}, {"bottom"}},
      {{"bottom"}, {"surface"}},   {{"bottom"}, {"bottom"}},
      {{"surface", "bottom"}, {}}, {{"bottom", "surface"}, {}}};
  REQUIRE(sea.plan.paths.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CAPTURE(i);
    CHECK(sea.plan.paths[i].id == i + 1);
    CHECK(sea.plan.paths[i].out == expected[i].first);
    CHECK(sea.plan.paths[i].back == expected[i].second);
  }
}

TEST_CASE("one bounce leaves the double reflection out") {
  const Sea sea(head(120) + target_at(10, 0.5, -1) +
                "multipath: {surface: {z_m: 3, reflection: -1}, bounces: 1}\n");
  std::vector<std::uint16_t> paths;
  for (const Scatterer& s : sea.bounced()) paths.push_back(s.path);
  CHECK(paths == std::vector<std::uint16_t>{1, 2});
}

// Protects the closed form e^(-2 k^2 h^2 cos^2 alpha), per bounce.
TEST_CASE("a rough surface takes from each bounce by its angle") {
  const double h = 3e-4, k = 2 * kPi * 3e5 / kSpeed;
  const Sea smooth(head(120) + target_at(10, 0.5, -1) + kSurface);
  const Sea rough(head(120) + target_at(10, 0.5, -1) +
                  "multipath: {surface: {z_m: 3, reflection: -0.9, roughness_rms_m: 3e-4}}\n");
  const double cosine = 7 / length(kImage);
  const double kept = 0.9 * std::exp(-2 * k * k * h * h * cosine * cosine);
  const auto before = smooth.bounced(), after = rough.bounced();
  REQUIRE(after.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(pressure(after[i]) / pressure(before[i]) ==
          Approx(after[i].path == 3 ? kept * kept : kept).epsilon(1e-6));
  }
}

// Protects both ends of a path: out and back must be inside the fan.
TEST_CASE("what leaves or comes outside the fan is not heard") {
  // The image stands 35 degrees up, the target 6 down.
  CHECK(Sea(head(60) + target_at(10, 0.5, -1) + kSurface).bounced().empty());
  CHECK(Sea(head(72) + target_at(10, 0.5, -1) + kSurface).bounced().size() == 3);
  // A wall to port shows the image 58 degrees off, beyond the last sector.
  const std::string wall = kMaterials +
                           "objects: [{name: wall, material: mirror, shape: {plane: {}}, pose: "
                           "{position_m: [0, 8, 0], rotation_deg: [90, 0, 0]}}]\n"
                           "multipath: {objects: true}\n";
  CHECK(Sea(head(60) + target_at(10, 0, 0) + wall).bounced().empty());
  CHECK(Sea(head(60, 4, 140) + target_at(10, 0, 0) + wall).bounced().size() == 3);
}

// Protects the visibility of every piece of a way, each for itself.
TEST_CASE("what stands in a way silences it alone") {
  const auto paths_behind = [](const std::string& box) {
    const Sea sea(head(120) + target_at(10, 0.5, -1) + kMaterials +
                  "objects: [{name: box, material: sand, " + box + "}]\n" + kSurface);
    std::vector<std::uint16_t> paths;
    for (const Scatterer& s : sea.bounced()) {
      if (s.instance == 2) paths.push_back(s.path);
    }
    return paths;
  };
  using Paths = std::vector<std::uint16_t>;
  const std::string half = "shape: {box: {size_m: [0.1, 2, 0.4]}}, pose: {position_m: ";
  CHECK(paths_behind(half + "[5, 9, 0]}") == Paths{1, 2, 3});
  // The surface is met at x = 30/7, z = 3.
  CHECK(paths_behind(half + "[2, 0.1, 1.4]}").empty());                  // on the way up
  CHECK(paths_behind(half + "[7, 0.3, 1.1]}").empty());                  // on the way down
  CHECK(paths_behind(half + "[5, 0.2, -0.5]}") == Paths{3});             // on the straight way
  CHECK(paths_behind(half + "[4.2857, 0.2, 3.25]}") == Paths{1, 2, 3});  // above the surface
}

// Protects the waveguide: count, delays and signs by the lattice of images.
TEST_CASE("surface and bottom make the lattice of images") {
  const double a = 4, b = 6, depth = a + b, z = -1.5;
  const Sea sea(head(170) + target_at(30, 2, z) +
                "multipath: {surface: {z_m: 4, reflection: -1}, bottom: {z_m: -6, reflection: "
                "0.5}, bounces: 4}\n");
  struct Way {
    int surface, bottom;
    Vec3 image;
  };
  std::vector<Way> ways;
  const auto add = [&](int surface, int bottom, double image_z) {
    ways.push_back({surface, bottom, {30, 2, image_z}});
  };
  for (int n = -2; n <= 2; ++n) add(std::abs(n), std::abs(n), z + 2 * n * depth);
  for (int n = 0; n <= 1; ++n) {
    add(n + 1, n, 2 * a - z + 2 * n * depth);
    add(n, n + 1, -2 * b - z - 2 * n * depth);
  }
  struct Arrival {
    double delay_s, pressure;
  };
  std::vector<Arrival> expected, found;
  for (const Way& out : ways) {
    for (const Way& back : ways) {
      const int up = out.surface + back.surface, down = out.bottom + back.bottom;
      if (up + down < 1 || up + down > 4) continue;
      expected.push_back({(length(out.image) + length(back.image)) / kSpeed,
                          std::pow(-1.0, up) * std::pow(0.5, down) *
                              target_pressure(sea.sonar, out.image, back.image)});
    }
  }
  for (const Scatterer& s : sea.bounced()) found.push_back({s.delay_s, pressure(s)});
  CHECK(expected.size() == 40);
  REQUIRE(found.size() == expected.size());
  std::ranges::sort(expected, {}, &Arrival::delay_s);
  std::ranges::sort(found, {}, &Arrival::delay_s);
  for (std::size_t i = 0; i < found.size(); ++i) {
    CAPTURE(i);
    CHECK(std::abs(found[i].delay_s - expected[i].delay_s) < 1e-12);
    CHECK(found[i].pressure == Approx(expected[i].pressure).epsilon(1e-6));
  }
}

// Protects the bounds of faces, and which side of a face is a mirror.
TEST_CASE("a box mirrors where its face is, a plane everywhere") {
  const auto echoes_by = [](const std::string& object) {
    return Sea(head(60, 4, 140) + target_at(10, 1, 0.5) + kMaterials +
               "objects: [{name: wall, material: mirror, " + object + "}]\n" +
               "multipath: {objects: true, bounces: 1}\n")
        .bounced();
  };
  // The face y = 4 is met at x = 40/7, z = 2/7.
  const Vec3 target{10, 1, 0.5}, image{10, 7, 0.5};
  const double cosine = 7 / length(image), kh = 2 * kPi * 3e5 / kSpeed * 1e-4 * cosine;
  const double reflection = 0.8 * std::exp(-2 * kh * kh);
  const std::string box = "shape: {box: {size_m: [1, 2, 1]}}, pose: {position_m: ";
  const std::string plane = "shape: {plane: {}}, pose: {position_m: [3, 4, 1], rotation_deg: ";
  const Sea sonar_of_it(head(60, 4, 140));
  for (const std::string& object :
       {box + "[5.5, 5, 0.2]}", plane + "[90, 0, 0]}", plane + "[-90, 0, 0]}"}) {
    CAPTURE(object);
    const auto echoes = echoes_by(object);
    REQUIRE(echoes.size() == 2);
    for (const Scatterer& s : echoes) {
      CHECK(std::abs(s.delay_s - (length(target) + length(image)) / kSpeed) < 1e-12);
    }
    CHECK(pressure(echoes[0]) ==
          Approx(reflection * target_pressure(sonar_of_it.sonar, target, image)).epsilon(1e-6));
  }
  CHECK(echoes_by(box + "[4.6, 5, 0.2]}").empty());   // short of x
  CHECK(echoes_by(box + "[5.5, 5, -0.3]}").empty());  // under z
  CHECK(echoes_by(box + "[5.5, 3, 0.2]}").empty());   // y = 4 seen from behind, y = 2 beside x
  // A room's walls are mirrors from within: two faces beside, and those above and below.
  const auto room = Sea(head(170, 4, 170) + target_at(10, 1, 0.5) + kMaterials +
                        "objects: [{name: room, material: mirror, shape: {box: {size_m: [40, 8, "
                        "12], inside: true}}}]\nmultipath: {objects: true, bounces: 1}\n")
                        .bounced();
  std::vector<double> delays, expected;
  for (const Scatterer& s : room) {
    if (s.instance == 2) delays.push_back(s.delay_s * kSpeed);
  }
  for (const Vec3 seen : {Vec3{10, 7, 0.5}, Vec3{10, -9, 0.5}, Vec3{10, 1, 11.5},
                          Vec3{10, 1, -12.5}, Vec3{30, 1, 0.5}}) {
    for (int way = 0; way < 2; ++way) expected.push_back(length(target) + length(seen));
  }
  std::ranges::sort(delays);
  std::ranges::sort(expected);
  REQUIRE(delays.size() == expected.size());
  for (std::size_t i = 0; i < delays.size(); ++i) CHECK(delays[i] == Approx(expected[i]));
}

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

// Protects mirrors that move: the image is the one of the moment.
TEST_CASE("a mirror is where its object is at the ping") {
  Sea sea(head(60, 4, 140) + target_at(10, 1, 0) + kMaterials +
          "objects: [{name: wall, material: mirror, shape: {box: {size_m: [6, 2, 2]}}, pose: "
          "{position_m: [5, 5, 0]}}]\nmultipath: {objects: true, bounces: 1}\n");
  for (const double y : {5.0, 5.5, 4.25}) {
    sea.poses[0].position_m.y = y;
    const Tracer moment = sea.tracer->at(sea.poses);
    const auto echoes =
        bounced_echoes({sea.plan, *sea.world, moment, sea.poses, {}, sea.scattering}, sea.fan,
                       moment.trace_fan(sea.fan, {}, 100, Workers(1)), Workers(1));
    REQUIRE(echoes.size() == 2);
    const double way = length(Vec3{10, 1, 0}) + length(Vec3{10, 2 * (y - 1) - 1, 0});
    CHECK(std::abs(echoes[0].delay_s - way / kSpeed) < 1e-12);
  }
}

// Protects the loss in volumes over the whole way.
TEST_CASE("volumes take from every piece of a way") {
  const std::string bare = head(120) + target_at(10, 0.5, -1) + kSurface;
  const Sea clear(bare), murky(bare +
                               "volumes: [{name: silt, uniform: {strength_db: -90}, "
                               "extinction_db_m: 0.4}]\n");
  const auto before = clear.bounced(), after = murky.bounced();
  REQUIRE(after.size() == before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    const double way = after[i].delay_s * kSpeed;
    CHECK(pressure(after[i]) / pressure(before[i]) == Approx(std::pow(10, -0.4 * way / 20)));
  }
}

// Protects range_min and range_max, which hold for c tau / 2.
TEST_CASE("bounced echoes are heard within the ranges of their delay") {
  const auto paths_up_to = [](const char* range_max_m) {
    std::string text = head(120) + target_at(10, 0.5, -1) + kSurface;
    text.replace(text.find("100"), 3, range_max_m);
    std::vector<std::uint16_t> paths;
    for (const Scatterer& s : Sea(text).bounced()) paths.push_back(s.path);
    return paths;
  };
  using Paths = std::vector<std::uint16_t>;
  // r = 10.06, r' = 12.22.
  CHECK(paths_up_to("12.3") == Paths{1, 2, 3});
  CHECK(paths_up_to("12.2") == Paths{1, 2});
  CHECK(paths_up_to("11.1").empty());
}

TEST_CASE("too many paths are refused with advice") {
  std::string text = head(60) + kMaterials + "objects:\n";
  for (int i = 0; i < 7; ++i) {
    text += fmt::format(
        "  - {{name: b{0}, material: mirror, shape: {{box: {{size_m: [1, 1, 1]}}}}, "
        "pose: {{position_m: [{0}, 9, 0]}}}}\n",
        2 * i);
  }
  auto scenario = parse_scenario(text + "multipath: {objects: true}\n", "t.yaml", ".");
  REQUIRE(scenario);
  const auto plan = make_bounce_plan(*scenario);
  REQUIRE(!plan);
  CHECK(plan.error().kind == ErrorKind::usage);
  CHECK(plan.error().message.find("multipath.bounces: 42 mirrors and 2 bounces give more than 4096 "
                                  "paths") == 0);
}
