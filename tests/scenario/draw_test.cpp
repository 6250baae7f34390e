#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::faults_of;
using testing::kHead;
using testing::tells;

Scenario drawn(const std::string& added, std::uint32_t sequence,
               const std::vector<Override>& overrides = {}) {
  INFO(added);
  return value_of(parse_scenario(kHead + added, "t.yaml", ".", overrides, sequence));
}

double mean_of(const std::vector<double>& x) {
  double sum = 0;
  for (const double value : x) sum += value;
  return sum / x.size();
}

double variance_of(const std::vector<double>& x) {
  const double mean = mean_of(x);
  double sum = 0;
  for (const double value : x) sum += (value - mean) * (value - mean);
  return sum / x.size();
}

// sqrt(n) sup |F_n - F|; 1.82 is passed once in 370.
double kolmogorov_smirnov(std::vector<double> x, const std::function<double(double)>& cdf) {
  std::sort(x.begin(), x.end());
  const double n = static_cast<double>(x.size());
  double distance = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double f = cdf(x[i]);
    distance = std::max({distance, f - i / n, (i + 1) / n - f});
  }
  return std::sqrt(n) * distance;
}

struct Samples {
  std::vector<double> x, y, z, strength;
};

// 8 sequences of 500 targets: 4000 draws of each distribution, seed 0.
Samples samples() {
  const std::string text =
      "point_targets:\n"
      "  - name: p\n"
      "    count: 500\n"
      "    target_strength_db: {normal: [-30, 4]}\n"
      "    position_m: [{uniform: [2.0, 8.0]}, {log_uniform: [0.01, 10]}, {uniform: [3, 6]}]\n";
  Samples all;
  for (std::uint32_t sequence = 0; sequence < 8; ++sequence) {
    for (const PointTargetSpec& target : drawn(text, sequence).point_targets) {
      all.x.push_back(target.position_m[0]);
      all.y.push_back(target.position_m[1]);
      all.z.push_back(target.position_m[2]);
      all.strength.push_back(target.target_strength_db);
    }
  }
  return all;
}

// Protects the laws that values are drawn from: moments within three standard errors of the closed
// forms (n = 4000), the whole distribution by Kolmogorov and Smirnov.
TEST_CASE("values follow their distributions") {
  const Samples s = samples();
  const double n = 4000;
  REQUIRE(s.x.size() == 4000);

  CHECK(std::abs(mean_of(s.x) - 5) < 3 * std::sqrt(3 / n));
  CHECK(std::abs(variance_of(s.x) / 3 - 1) < 3 * std::sqrt(0.8 / n));
  CHECK(kolmogorov_smirnov(s.x, [](double x) { return (x - 2) / 6; }) < 1.82);

  const double decades = std::log(1000);
  std::vector<double> logarithms;
  for (const double y : s.y) logarithms.push_back(std::log(y / 0.01) / decades);
  CHECK(std::abs(mean_of(logarithms) - 0.5) < 3 * std::sqrt(1 / 12.0 / n));
  CHECK(std::abs(variance_of(logarithms) * 12 - 1) < 3 * std::sqrt(0.8 / n));
  CHECK(kolmogorov_smirnov(logarithms, [](double u) { return u; }) < 1.82);

  CHECK(std::abs(mean_of(s.strength) + 30) < 3 * 4 / std::sqrt(n));
  CHECK(std::abs(variance_of(s.strength) / 16 - 1) < 3 * std::sqrt(2 / n));
  CHECK(kolmogorov_smirnov(s.strength, [](double x) {
          return 0.5 * std::erfc(-(x + 30) / 4 / std::sqrt(2.0));
        }) < 1.82);
}

// Protects whole numbers where they are read, and only there: both ends drawn, all as often (a
// quarter each of n = 1000, with a standard error of 14; ends drawn half as often have 167).
TEST_CASE("where whole numbers are read all whole numbers are drawn") {
  std::map<int, int> pings, rays;
  for (std::uint32_t sequence = 0; sequence < 1000; ++sequence) {
    const auto scenario = value_of(
        parse_scenario("ensonify: 1\n"
                       "sonar: {preset: blueview_p900_90, rays: {elevation: {uniform: [3, 6]}}}\n"
                       "trajectory: {pings: {uniform: [3, 6]}}\n",
                       "t.yaml", ".", {}, sequence));
    ++pings[*scenario.trajectory.pings];
    ++rays[scenario.sonar.rays_elevation];
  }
  for (const auto* times : {&pings, &rays}) {
    REQUIRE(times->size() == 4);
    for (const auto& [value, count] : *times) {
      INFO(value);
      CHECK(value >= 3);
      CHECK(value <= 6);
      CHECK(std::abs(count - 250) < 3 * std::sqrt(1000 * 0.25 * 0.75));
    }
  }
}

TEST_CASE("lengths between whole numbers are not whole") {
  const Samples s = samples();
  CHECK(kolmogorov_smirnov(s.z, [](double z) { return (z - 3) / 3; }) < 1.82);
}

// Protects against draws that hang together: coordinates of one target, and one value in neighbours
// and in following sequences, have correlations of standard error 1 / sqrt(n).
TEST_CASE("draws of different values, objects and sequences are independent") {
  const Samples s = samples();
  const auto correlation = [](const std::vector<double>& a, const std::vector<double>& b,
                              std::size_t lag) {
    const double mean_a = mean_of(a), mean_b = mean_of(b);
    double sum = 0;
    for (std::size_t i = 0; i + lag < a.size(); ++i) sum += (a[i] - mean_a) * (b[i + lag] - mean_b);
    return sum / static_cast<double>(a.size() - lag) / std::sqrt(variance_of(a) * variance_of(b));
  };
  CHECK(std::abs(correlation(s.x, s.strength, 0)) < 3 / std::sqrt(4000));
  CHECK(std::abs(correlation(s.x, s.z, 0)) < 3 / std::sqrt(4000));
  CHECK(std::abs(correlation(s.x, s.x, 1)) < 3 / std::sqrt(3999));
  CHECK(std::abs(correlation(s.x, s.x, 500)) < 3 / std::sqrt(3500));
}

const std::string kWorld =
    "materials: {m: {reflectivity: {log_uniform: [1e-4, 1e-2]}}, n: {reflectivity: 1}}\n"
    "objects:\n"
    "  - {name: a, material: {choice: [m, n]}, shape: {choice: [{sphere: {radius_m: {uniform: "
    "[0.1, 0.5]}}}, {box: {size_m: [1, {normal: [2, 0.1]}, 1]}}]}, pose: {position_m: [{uniform: "
    "[2.0, 8.0]}, 0, 0]}}\n";

// Protects a world under construction: what is added beside an object, before or after it, leaves
// its draws as they are; its name is what they hang on.
TEST_CASE("a draw depends on names and not on order") {
  const std::string other =
      "  - {name: b, count: {uniform: [0, 3]}, material: m, shape: {sphere: {radius_m: {uniform: "
      "[0.1, 0.5]}}}}\n";
  const std::size_t at = kWorld.find("  - {name: a");
  std::string first = kWorld;
  first.insert(at, other);
  std::string renamed = kWorld;
  renamed.replace(at, 12, "  - {name: c");
  int same = 0;
  for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
    const Scenario alone = drawn(kWorld, sequence);
    for (const std::string& text : {kWorld + other, first}) {
      const Scenario beside = drawn(text, sequence);
      for (const DrawnValue& value : alone.draws) {
        CHECK(std::find(beside.draws.begin(), beside.draws.end(), value) != beside.draws.end());
      }
    }
    same += drawn(renamed, sequence).objects[0].pose.position_m == alone.objects[0].pose.position_m;
  }
  CHECK(same == 0);
}

// Protects alternatives: each is drawn as often, and the one that is drawn is read whole.
TEST_CASE("a choice may hold whole maps with draws of their own") {
  int spheres = 0;
  for (std::uint32_t sequence = 0; sequence < 400; ++sequence) {
    const Scenario s = drawn(kWorld, sequence);
    if (const auto* sphere = std::get_if<SphereSpec>(&s.objects[0].shape)) {
      ++spheres;
      CHECK(sphere->radius_m > 0.1);
      CHECK(sphere->radius_m < 0.5);
    }
  }
  CHECK(std::abs(spheres - 200) < 3 * std::sqrt(400 * 0.25));
}

TEST_CASE("what was drawn is recorded under names") {
  const Scenario s = drawn(kWorld, 3);
  const auto value_of = [&](const std::string& path) {
    for (const DrawnValue& value : s.draws) {
      if (value.path == path) return value.value;
    }
    return std::string();
  };
  CHECK(s.has_draws);
  CHECK(value_of("objects.a.material") == s.objects[0].material);
  CHECK(std::stod(value_of("objects.a.pose.position_m.0")) == s.objects[0].pose.position_m[0]);
  CHECK(std::stod(value_of("materials.m.reflectivity")) == s.materials[0].reflectivity);
  const bool sphere = std::holds_alternative<SphereSpec>(s.objects[0].shape);
  CHECK(value_of("objects.a.shape.choice") == (sphere ? "0" : "1"));
  CHECK(value_of("objects.a.shape.sphere.radius_m").empty() == !sphere);
  CHECK_FALSE(drawn("water: {sound_speed_m_s: 1480}\n", 3).has_draws);
  CHECK(
      drawn("water: {sound_speed_m_s: {choice: [{uniform: [1400.5, 1500]}]}}\n", 3).draws.size() ==
      1);
}

// Protects counts: names, numbers from none on, and draws of the copies' own.
TEST_CASE("an entry with a count stands for as many") {
  const std::string text =
      "point_targets:\n"
      "  - {name: p, count: {choice: [0, 1, 3]}, target_strength_db: {uniform: [-40.0, -20]}, "
      "position_m: [1, 0, 0]}\n"
      "  - {name: q, target_strength_db: -30, position_m: [2, 0, 0]}\n";
  std::map<std::size_t, int> times;
  for (std::uint32_t sequence = 0; sequence < 60; ++sequence) {
    const Scenario s = drawn(text, sequence);
    ++times[s.point_targets.size()];
    CHECK(s.point_targets.back().name == "q");
    if (s.point_targets.size() != 4) continue;
    CHECK(s.point_targets[2].name == "p_2");
    CHECK(s.point_targets[1].target_strength_db != s.point_targets[2].target_strength_db);
  }
  CHECK(times.size() == 3);
  CHECK(times[1] > 0);
  CHECK(times[2] > 0);
}

// Protects `--set` over what is drawn.
TEST_CASE("an override takes the place of a distribution") {
  const std::string text = "water: {sound_speed_m_s: {uniform: [1400.0, 1500]}}\n";
  CHECK(drawn(text, 5, {{"water.sound_speed_m_s", "1471"}}).water.sound_speed_m_s == 1471);
  const Scenario other = drawn(text, 5, {{"water.sound_speed_m_s.choice", "[1432]"}});
  CHECK(other.water.sound_speed_m_s == 1432);
  const Scenario preset = drawn(
      "", 5,
      {{"sonar.beams.count", "{uniform: [7, 9]}"}, {"sonar.preset", "{choice: [seabat_f50]}"}});
  CHECK(preset.sonar.frequency_hz == 400e3);
  CHECK(preset.sonar.beam_count >= 7);
  CHECK(preset.sonar.beam_count <= 9);
}

// Protects whoever mistypes a distribution: told once, where it stands.
TEST_CASE("a distribution that cannot be drawn is told with its place") {
  const auto speed = [](const std::string& value) {
    return "water: {sound_speed_m_s: " + value + "}\n";
  };
  testing::check_single_faults({
      {speed("{uniform: [9, 3]}"), "4:36: water.sound_speed_m_s.uniform:", "9 is above 3"},
      {speed("{uniform: [9]}"), "4:36: water.sound_speed_m_s.uniform:", "a list of length 1"},
      {speed("{uniform: [a, 3]}"), "4:37: water.sound_speed_m_s.uniform.0:", "`a` is not a number"},
      {speed("{choice: []}"), "4:35: water.sound_speed_m_s.choice:", "empty"},
      {speed("{log_uniform: [0, 3]}"),
       "4:40: water.sound_speed_m_s.log_uniform:", "do not both have a logarithm"},
      {speed("{normal: [1500, -1]}"), "4:35: water.sound_speed_m_s.normal:", "standard deviation"},
      {speed("{uniform: [1, 2]}"), "4:26: water.sound_speed_m_s:", "out of range"},
      {"sequences: {uniform: [1, 2]}\n", "4:12: sequences:", "cannot be sampled"},
      {"seed: {choice: [1, 2]}\n", "4:7: seed:", "cannot be sampled"},
      {"volumes: [{name: {choice: [a, b]}, uniform: {strength_db: -60}}]\n",
       "4:18: volumes.0.name:", "cannot be sampled"},
      {"point_targets: [{name: p, count: -1, target_strength_db: 1, position_m: [1, 0, 0]}]\n",
       "4:34: point_targets.0.count:", "out of range"},
      {"objects: [{name: p, count: 2, material: m, shape: {plane: {}}}]\n",
       "4:41: objects.0.material:", "no material"},
  });
  CHECK(faults_of(kHead + "volumes: [{name: v, uniform: {strength_db: {uniform: [-70, -60]}}}]\n")
            .empty());
}

TEST_CASE("counts that stand for too much are refused", "[figure]") {
  const std::string entry =
      "count: 65534, target_strength_db: 1, position_m: [1, 0, 0], class: c}\n";
  std::string text = kHead + "point_targets:\n";
  for (const char* name : {"a", "b", "c", "d", "e", "f"}) {
    text += std::string("  - {name: ") + name + ", " + entry;
  }
  CHECK(tells(faults_of(text), "t.yaml:9:", "counts stand for more than 2000000 values"));
}

const std::string kRock =
    "objects:\n"
    "  - {name: floor, material: m, shape: {plane: {}}}\n"
    "  - {name: rock, material: m, shape: {sphere: {radius_m: 1}}, place: ";

TEST_CASE("a place says what it stands on and where") {
  const std::string head = "materials: {m: {reflectivity: 1}}\n" + kRock;
  const Scenario s = drawn(head + "{on: floor, area_m: [[-1, {uniform: [-9, -5]}], [1, 2]]}}\n", 0);
  REQUIRE(s.objects[1].place);
  CHECK(s.has_draws);
  CHECK(s.objects[1].place->on == "floor");
  CHECK(s.objects[1].place->area_m[0][1] <= -5);
  CHECK(s.objects[1].place->clearance_m == 0.2);
  CHECK(s.objects[1].place->any_yaw);
  testing::check_single_faults({
      {head + "{on: flor, area_m: [[0, 0], [1, 1]]}}\n",
       "7:75: objects.1.place.on:", "no object `flor` (did you mean floor?)"},
      {head + "{on: rock, area_m: [[0, 0], [1, 1]]}}\n", "7:75: objects.1.place.on:", "before"},
      {head + "{on: floor}}\n", "7:70: objects.1.place.area_m:", "missing"},
      {head + "{on: floor, area_m: [[0, 0], [-1, 1]]}}\n",
       "7:90: objects.1.place.area_m:", "x0 <= x1"},
      {head + "{on: floor, area_m: [[0, 0], [1]]}}\n",
       "7:99: objects.1.place.area_m.1:", "a list of 2 numbers"},
      {head + "{on: floor, area_m: [[0, 0], [1, 1]], align: side}}\n",
       "7:115: objects.1.place.align:", "not known"},
      {head + "{on: floor, area_m: [[0, 0], [1, 1]]}, pose: {}}\n",
       "7:115: objects.1.pose:", "with place"},
      {head + "{on: floor, area_m: [[0, 0], [1, 1]], scour: {depth_m: 0.1, width_m: 0.3}}}\n",
       "7:115: objects.1.place.scour:", "`floor` has no heightfield"},
  });
}

// Protects every key of scour, read and written, with numbers that are sampled.
TEST_CASE("a place leaves scour on terrain") {
  const std::string head =
      "materials: {m: {reflectivity: 1}}\n"
      "objects:\n"
      "  - {name: bed, material: m, shape: {heightfield: {size_m: [9, 9], cell_m: 1}}}\n"
      "  - {name: rock, material: m, shape: {sphere: {radius_m: 1}}, place: {on: bed, area_m: [[0, "
      "0], [1, 1]], scour: ";
  const Scenario s =
      drawn(head + "{depth_m: {uniform: [0.1, 0.2]}, width_m: 0.5, direction_deg: -20}}}\n", 0);
  const ScourSpec& scour = *s.objects[1].place->scour;
  CHECK((scour.depth_m > 0.1 && scour.depth_m < 0.2));
  CHECK(scour.width_m == 0.5);
  CHECK_FALSE(scour.mound_m);
  CHECK(scour.direction_deg == -20.0);
  const Scenario full = drawn(head + "{depth_m: 0.1, width_m: 0.5, mound_m: 0.02}}}\n", 0);
  const auto again = value_of(testing::parse(testing::emit(full)));
  CHECK(again.objects[1].place->scour->mound_m == 0.02);
  CHECK_FALSE(again.objects[1].place->scour->direction_deg);
}

}  // namespace
// Protects ids of classes, which must be the same in every sequence: every class that any draw can
// bring is known, that of entries without one and of lists drawn as a whole included.
TEST_CASE("classes are those of all alternatives, in every sequence") {
  const std::string text =
      "materials: {m: {reflectivity: 1}}\n"
      "objects: {choice: [[{name: a, class: {choice: [x, y]}, material: m, shape: {plane: {}}}],\n"
      "  [{choice: [{name: b, material: m, shape: {plane: {}}},\n"
      "             {name: c, class: z, material: m, shape: {plane: {}}}]}]]}\n"
      "point_targets: [{name: p, target_strength_db: 0, position_m: [1, 0, 0]}]\n";
  const std::vector<std::string> expected = {"x", "y", "object", "z", "point_target"};
  for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
    CHECK(drawn(text, sequence).class_names == expected);
  }
}

}  // namespace ensonify
