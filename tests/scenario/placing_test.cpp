// What objects hang from, stand on and float in, and copies with numbers.
#include <fmt/format.h>

#include "catch.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using test::TemporaryFolder;
using testing::check_single_faults;
using testing::emit;
using testing::FaultCase;
using testing::kHead;
using testing::parse;

const std::string kObjectsHead = "materials: {m: {reflectivity: 1}}\nobjects:\n";

// One object in each line, from line 6 on.
std::string objects(const std::vector<std::string>& each) {
  std::string text = kObjectsHead;
  for (const std::string& object : each) {
    text += "  - {material: m, shape: {sphere: {radius_m: 0.1}}, " + object + "}\n";
  }
  return text;
}

Scenario read(const std::string& added, std::uint32_t sequence = 0) {
  INFO(added);
  return value_of(parse_scenario(kHead + added, "t.yaml", ".", {}, sequence));
}

}  // namespace

TEST_CASE("wrong parents are told with their names") {
  const FaultCase cases[] = {
      {objects({"name: buoy", "name: rope, pose: {parent: bouy}"}), "7:80: objects.1.pose.parent: ",
       "no object `bouy` (did you mean buoy?); expected the name of an object"},
      {objects({"name: a, pose: {parent: a}"}),
       "6:77: objects.0.pose.parent: ", "the parents a form a cycle"},
      {objects({"name: x, pose: {parent: c}", "name: c, pose: {parent: b}",
                "name: b, pose: {parent: c}"}),
       "7:77: objects.1.pose.parent: ",
       "the parents b, c form a cycle; expected a chain that ends"},
      {objects(
           {"name: a", "name: b, place: {volume_m: [[0, 0, 0], [1, 1, 1]]}, pose: {parent: a}"}),
       "7:111: objects.1.pose: ", "has no effect with place"},
      {objects({"name: plate, pose: {parent: leg}", "name: floor",
                "name: cup, place: {on: plate, area_m: [[0, 0], [1, 1]]}",
                "name: leg, place: {on: floor, area_m: [[0, 0], [1, 1]]}"}),
       "8:76: objects.2.place.on: ",
       "the object `plate` moves with `leg`, which does not come before"},
  };
  check_single_faults({std::begin(cases), std::end(cases)});
}

TEST_CASE("wrong places in the water are told") {
  const std::string box = "volume_m: [[0, 0, 0], [1, 1, 1]]";
  check_single_faults({
      {objects({"name: a, place: {" + box + ", height_m: 1}"}),
       "6:114: objects.0.place.height_m: ", "has no effect with volume_m"},
      {objects({"name: a, place: {" + box + ", align: rest}"}),
       "6:111: objects.0.place.align: ", "has no effect with volume_m"},
      {objects({"name: a, place: {volume_m: [[0, 0, 0], [1, 1, -1]]}"}),
       "6:80: objects.0.place.volume_m: ", "x0 <= x1, y0 <= y1 and z0 <= z1"},
      {objects({"name: a",
                "name: b, place: {on: a, area_m: [[0, 0], [1, 1]], heap: true, touching: true}"}),
       "7:125: objects.1.place.touching: ", "has no effect with heap"},
  });
}

// Copies hang from copies of the same number, all from one parent, or from one that is named.
TEST_CASE("parents of copies are told apart by their numbers") {
  const std::string shared = "variables: {n: {uniform: [1, 4]}}\n";
  for (std::uint32_t sequence = 0; sequence < 20; ++sequence) {
    const Scenario scenario =
        read(shared + objects({"name: rope, count: $n, pose: {parent: buoy}",
                               "name: flag, count: 2, pose: {parent: mast}", "name: mast",
                               "name: buoy, count: $n", "name: lamp, pose: {parent: buoy_0}"}),
             sequence);
    const std::size_t n = (scenario.objects.size() - 4) / 2;
    REQUIRE(n >= 1);
    for (std::size_t i = 0; i < n; ++i) {
      CHECK(scenario.objects[i].name == fmt::format("rope_{}", i));
      CHECK(scenario.objects[i].parent == fmt::format("buoy_{}", i));
    }
    CHECK(scenario.objects[n].parent == "mast");
    CHECK(scenario.objects[n + 1].parent == "mast");
    CHECK(scenario.objects.back().parent == "buoy_0");
    const std::string text = emit(scenario);
    CHECK(contains(text, "parent: buoy}"));
    const auto again = value_of(parse_scenario(text, "again.yaml", ".", {}, sequence));
    CHECK(again.objects.back().parent == "buoy_0");
    CHECK(emit(again) == text);
  }
  check_single_faults({
      {objects({"name: buoy, count: 3", "name: rope, count: 2, pose: {parent: buoy}"}),
       "7:90: objects.3.pose.parent: ",
       "`rope` stands for 2 objects and its parent `buoy` for 3; expected equal counts"},
      {objects({"name: buoy, count: 3", "name: rope, pose: {parent: buoy}"}),
       "7:80: objects.3.pose.parent: ",
       "`buoy` stands for 3 objects; expected the name of one of them, as buoy_0"},
  });
}

// Protects rows: the number of a copy stands in its expressions, with its own draws beside it.
TEST_CASE("copies know their numbers") {
  const Scenario scenario =
      read("variables: {x: 2, gap: 1.5}\n" +
           objects({"name: post, count: 4, pose: {position_m: [\"= x + gap * index\", {uniform: "
                    "[\"= index - 0.1\", \"= index + 0.1\"]}, $index]}"}));
  REQUIRE(scenario.objects.size() == 4);
  for (int k = 0; k < 4; ++k) {
    const auto& [x, y, z] = scenario.objects[static_cast<std::size_t>(k)].pose.position_m;
    CHECK(x == 2 + 1.5 * k);
    CHECK(std::abs(y - k) <= 0.1);
    CHECK(y != k);
    CHECK(z == k);
  }
  check_single_faults({
      {"variables: {index: 3}\n", "4:13: variables.index: ", "not a name for a variable"},
      {"water: {sound_speed_m_s: $index}\n",
       "4:26: water.sound_speed_m_s: ", "no variable `index`"},
      {objects({"name: post, pose: {position_m: [$index, 0, 0]}"}),
       "6:85: objects.0.pose.position_m.0: ", "is not a number"},
  });
}

// A resolved text reads back to itself.
TEST_CASE("parents, volumes and scales are written as they are read") {
  const TemporaryFolder folder;
  const std::string mesh = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").string();
  const Scenario scenario = read(kObjectsHead +
                                 "  - {name: floor, material: m, shape: {plane: {}}}\n"
                                 "  - {name: even, material: m, shape: {mesh: {file: " +
                                 mesh +
                                 ", scale: 2}}, pose: {parent: floor}}\n"
                                 "  - {name: uneven, material: m, shape: {mesh: {file: " +
                                 mesh +
                                 ", scale: [2, 1, 0.5]}}}\n"
                                 "  - {name: floats, material: m, shape: {sphere: {radius_m: 1}}, "
                                 "place: {volume_m: [[0, 0, 0], [1, 2, 3]]}}\n"
                                 "  - {name: hovers, material: m, shape: {sphere: {radius_m: 1}}, "
                                 "place: {on: floor, area_m: [[0, 0], [1, 2]], height_m: 2}}\n");
  CHECK(std::get<MeshSpec>(scenario.objects[1].shape).scale == std::array<double, 3>{2, 2, 2});
  CHECK(std::get<MeshSpec>(scenario.objects[2].shape).scale == std::array<double, 3>{2, 1, 0.5});
  const std::string text = emit(scenario);
  INFO(text);
  CHECK(contains(text, "scale: 2,"));
  CHECK(contains(text, "scale: [2, 1, 0.5]"));
  CHECK(contains(text, "parent: floor"));
  CHECK(contains(text, "volume_m: [[0, 0, 0], [1, 2, 3]]"));
  const auto again = value_of(parse(text));
  CHECK(emit(again) == text);
}

}  // namespace ensonify
