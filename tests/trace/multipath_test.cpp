// Bounced echoes of targets against the image method, worked out here from mirrored points.
#include "trace/multipath.h"
#include "scenario/scenario.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "catch.h"
#include "core/units.h"
#include "mirrored_sea.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

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
                        "12], inward_facing: true}}}]\nmultipath: {objects: true, bounces: 1}\n")
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

// Protects against a data set that promises ghosts and has none.
TEST_CASE("multipath without a mirror is refused") {
  auto scenario =
      parse_scenario(head(60) + kMaterials +
                         "objects: [{name: b, material: mirror, shape: {sphere: {radius_m: 1}}}]\n"
                         "multipath: {objects: true}\n",
                     "t.yaml", ".");
  REQUIRE(scenario);
  const auto plan = make_bounce_plan(scenario->multipath, flat_reflectors(*scenario));
  REQUIRE(!plan);
  CHECK(plan.error().kind == ErrorKind::usage);
  CHECK(plan.error().message.find("multipath.objects: no object is a specular reflector") == 0);
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
  const auto plan = make_bounce_plan(scenario->multipath, flat_reflectors(*scenario));
  REQUIRE(!plan);
  CHECK(plan.error().kind == ErrorKind::usage);
  CHECK(plan.error().message.find("multipath.bounces: 42 specular reflectors and 2 bounces give "
                                  "more than 4096 paths") == 0);
}
