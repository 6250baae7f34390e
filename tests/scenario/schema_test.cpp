#include <fmt/format.h>

#include <functional>
#include <set>
#include <utility>

#include "catch.h"
#include "scenario/schema.h"
#include "scenario_schema.h"
#include "scenario_texts.h"

namespace ensonify::testing {
namespace {

const Samples& samples() {
  static const Samples made;
  return made;
}

Result<Scenario> parsed(const std::string& text, const std::vector<Override>& overrides = {}) {
  return parse_scenario(text, "t.yaml", samples().folder(), overrides);
}

std::string joined_to(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + "." + key;
}

using Visit = std::function<void(const Json& map, const Json& value, const std::string& path)>;

// Every map of a scenario with what the schema says of it; what is drawn is left out.
void walk(const Json& use, const Json& value, const std::string& path, const Visit& visit) {
  if (const Json* list = value.is_array() ? list_schema(use) : nullptr) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      walk(list->at("items"), value[i], joined_to(path, std::to_string(i)), visit);
    }
  }
  const Json* map = value.is_object() && !value.contains("choice") ? map_schema(use) : nullptr;
  if (map == nullptr) return;
  visit(*map, value, path);
  for (const auto& [key, inner] : value.items()) {
    const Json& properties = map->at("properties");
    walk(properties.contains(key) ? properties.at(key) : map->at("additionalProperties"), inner,
         joined_to(path, key), visit);
  }
}

void walk_samples(const std::function<void(const std::string& text, const Json& map,
                                           const Json& value, const std::string& path)>& visit) {
  for (const std::string& text : samples().texts()) {
    walk(schema(), json_of(text), "",
         [&](const Json& map, const Json& value, const std::string& path) {
           visit(text, map, value, path);
         });
  }
}

}  // namespace

// Protects writers of scenarios from an editor that marks what the program takes, and readers of
// data sets: the resolved text is a scenario too.
TEST_CASE("every scene and every example is as the schema says, resolved as well") {
  CHECK(samples().texts().size() > 25);
  for (const std::string& text : samples().texts()) {
    INFO(text);
    const auto scenario = value_of(parsed(text));
    CHECK(schema_fault(json_of(text)) == "");
    const std::string resolved = emit(scenario);
    INFO(resolved);
    CHECK(schema_fault(json_of(resolved)) == "");
  }
}

// Rows by range are of presets alone; each has keys of a sonar, beside its limit.
TEST_CASE("every preset is as the schema says, with the keys of each row") {
  for (const SonarPreset& preset : sonar_presets()) {
    INFO(preset.name);
    Json sonar = json_of(preset.yaml);
    const Json rows = sonar.value("by_range_max_m", Json::array());
    sonar.erase("by_range_max_m");
    CHECK(schema_fault({{"ensonify", 1}, {"sonar", sonar}}) == "");
    for (Json row : rows) {
      CHECK(row.erase("up_to_m") == 1);
      Json chosen = sonar;
      chosen.update(row);
      CHECK(schema_fault({{"ensonify", 1}, {"sonar", chosen}}) == "");
    }
  }
}

// Protects from a schema that is stricter than the program: whatever is done to a value, what the
// parser still takes, the schema takes.
TEST_CASE("the schema refuses nothing that the parser takes", "[figure]") {
  std::set<std::pair<const Json*, std::string>> seen;
  std::size_t taken = 0, refused = 0;
  walk_samples(
      [&](const std::string& text, const Json& map, const Json& value, const std::string& path) {
        const Json whole = json_of(text);
        for (const auto& [key, old] : value.items()) {
          if (!seen.emplace(&map, key).second) continue;
          std::string pointer = fmt::format("/{}", joined_to(path, key));
          std::replace(pointer.begin(), pointer.end(), '.', '/');
          const Json changes[] = {nullptr,
                                  "x",
                                  -1,
                                  1,
                                  true,
                                  Json::array(),
                                  Json::object(),
                                  {{"choice", {{{"choice", {old, old}}}}}},
                                  {{"uniform", {old, old}}}};
          for (std::size_t i = 0; i <= std::size(changes); ++i) {
            Json changed = whole;
            const Json::json_pointer at(pointer);
            if (i < std::size(changes)) changed[at] = changes[i];
            if (i == std::size(changes)) changed[at.parent_pointer()].erase(at.back());
            const std::string changed_text = changed.dump(1);
            const bool accepted = parsed(changed_text).ok();
            const bool fits = schema_accepts(changed);
            if (accepted && !fits) {
              INFO(pointer << "\n" << changed[at.parent_pointer()].dump(1));
              CHECK(schema_fault(changed) == "");
            }
            taken += accepted ? 1 : 0;
            refused += !accepted && !fits ? 1 : 0;
          }
        }
      });
  CHECK(taken > 200);
  CHECK(refused > 500);
}

// Protects whoever relies on the editor: the usual mistakes are seen by both.
TEST_CASE("wrong scenarios are refused by the schema and the parser") {
  const std::string objects = "materials: {m: {reflectivity: 1}}\nobjects:\n  - ";
  const std::string wrong[] = {
      "name: t\nsonar: {preset: blueview_p900_90}\n",
      "ensonify: 2\nsonar: {preset: blueview_p900_90}\n",
      "ensonify: 1\nname: t\n",
      "ensonify: 1\nsonar: {frequency_hz: 9e5}\n",
      "ensonify: 1\nsonar: {preset: blueview}\n",
      kHead + "colour: red\n",
      kHead + "seed: -1\n",
      kHead + "sequences: 0\n",
      kHead + "seed: {uniform: [1, 2]}\n",
      kHead + "water: {sound_speed_m_s: 50}\n",
      kHead + "water: {sound_speed_m_s: {uniform: [1400]}}\n",
      kHead + "water: {absorption: {fixed_db_m: 0, ph: 8}}\n",
      kHead + "water: {absorption: {ph: 8}}\n",
      kHead + "water: {profile: {depth_m: [0]}}\n",
      kHead + "water: {profile: {depth_m: [0], sound_speed_m_s: [50]}}\n",
      kHead + "water: {profile: {depth_m: [0], sound_speed_m_s: [1500], file: a.csv}}\n",
      kHead + "water: {profile: {surface_z_m: 0}}\n",
      kHead + "materials: {m: {}}\n",
      kHead + "materials: {m: {reflectivity: 1, law: {table: {file: sand.csv}}}}\n",
      kHead + "materials: {m: {reflectivity: 1, coherent: {model: rician}}}\n",
      kHead + "materials: {m: {reflectivity: 1, coherent: {model: kirchhoff, k: 1}}}\n",
      kHead + objects + "{name: o, material: m}\n",
      kHead + objects + "{name: o, material: m, shape: {}}\n",
      kHead + objects + "{name: o, material: m, shape: {plane: {}, sphere: {radius_m: 1}}}\n",
      kHead + objects + "{name: o, material: m, shape: {sphere: {radius_m: 0}}}\n",
      kHead + objects + "{name: o, material: m, shape: {sphere: {radius_mm: 1}}}\n",
      kHead + objects + "{name: o, material: m, shape: {box: {size_m: [1, 1]}}}\n",
      kHead + objects + "{name: o, material: m, shape: {plane: {}}, pose: {position_m: 1}}\n",
      kHead + objects +
          "{name: o, material: m, shape: {plane: {}}, pose: {rotation_deg: [0, 0, 0], "
          "quaternion_wxyz: [1, 0, 0, 0]}}\n",
      kHead + objects +
          "{name: o, material: m, shape: {plane: {}}, pose: {}, trajectory: {poses: [{}]}}\n",
      kHead + objects +
          "{name: o, material: m, shape: {plane: {}}, trajectory: {poses: [{}], pings: 2}}\n",
      kHead + objects + "{name: o, material: m, shape: {heightfield: {cell_m: 1}}}\n",
      kHead + objects +
          "{name: o, material: m, shape: {heightfield: {file: a.npy, cell_m: 1, roughness: "
          "{rms_m: 1}}}}\n",
      kHead + "point_targets: [{name: p, position_m: [0, 0, 0]}]\n",
      kHead + "volumes: [{name: v}]\n",
      kHead +
          "volumes: [{name: v, plume: {radius_m: 1, height_m: 1, strength_db: 0}, "
          "extinction_db_m: 1}]\n",
      kHead + "trajectory: {poses: []}\n",
      kHead + "trajectory: {poses: [{}], file: a.csv}\n",
      kHead + "trajectory: {pings: 0}\n",
      kHead + "noise: {}\n",
      kHead + "noise: {snr_db: 1, spectrum_level_db: 1}\n",
      kHead + "output: {timeseries: exrr}\n",
      kHead + "output: {png: {db: [1]}}\n",
      kHead + "output: {cartesian: 3}\n",
      kHead + "splits: {train: -1}\n",
  };
  for (const std::string& text : wrong) {
    INFO(text);
    CHECK_FALSE(parsed(text).ok());
    CHECK(schema_fault(json_of(text)) != "");
  }
}

// Protects data sets of earlier versions' users from a schema that nobody has generated anew.
TEST_CASE("the schema in output_schema is generated from the fields as they are") {
  CHECK(schema() == Json::parse(scenario_schema()));
}

}  // namespace ensonify::testing
