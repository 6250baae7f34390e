#include <fmt/format.h>
#include <fmt/ranges.h>

#include <functional>
#include <set>
#include <utility>

#include "catch.h"
#include "scenario/reader.h"
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

// The line of the first fault at this key path; empty: none.
std::string fault_at(const std::string& text, const std::vector<Override>& overrides,
                     const std::string& path) {
  const auto scenario = parsed(text, overrides);
  if (scenario.ok()) return {};
  const std::string& message = scenario.error().message;
  const std::size_t at = message.find(": " + path + ": ");
  if (at == std::string::npos) return {};
  return message.substr(at, message.find('\n', at) - at);
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

// The keys that the schema knows and the reader reads; how many copies an entry stands for has been
// looked at before the reader sees it.
std::set<std::string> keys_of(const Json& map) {
  std::set<std::string> keys;
  for (const auto& [key, inner] : map.at("properties").items()) keys.insert(key);
  keys.erase("choice");
  return keys;
}

bool has_free_names(const Json& map) { return map.at("additionalProperties").is_object(); }

std::set<std::string> words_in(std::string text) {
  std::set<std::string> words;
  for (std::size_t end; !text.empty(); text.erase(0, end)) {
    end = std::min(text.find(", "), text.size());
    words.insert(text.substr(0, end));
    end = std::min(end + 2, text.size());
  }
  return words;
}

// What the schema says of a value, in the words of the reader's messages; empty: it is a map.
std::string in_words(const Json& use);

std::string in_words_of_alternatives(const Json& use) {
  const Json& first = use.at("anyOf").at(0);
  if (first.contains("type")) return "true (on), false (off) or a map of options";
  if (!first.contains("enum")) return in_words(first);
  const Json* map = map_schema(use);
  std::vector<std::string> words = first.at("enum");
  // A kind: each word may have options.
  if (keys_of(*map).size() > 0) return "one of ";
  return "one of " + fmt::format("{}", fmt::join(words, ", "));
}

NumberRange range_of(const Json& use) {
  const bool excluded = use.contains("exclusiveMinimum");
  return {use.at(excluded ? "exclusiveMinimum" : "minimum"), use.at("maximum"), excluded};
}

std::string in_words(const Json& use) {
  if (use.contains("$ref")) {
    return in_words(schema().at(Json::json_pointer(use.at("$ref").get<std::string>().substr(1))));
  }
  if (use.contains("const")) return use.at("const").dump();
  if (use.contains("anyOf")) return in_words_of_alternatives(use);
  const Json& plain = use.contains("allOf")
                          ? schema().at(Json::json_pointer(
                                use.at("allOf").at(0).at("$ref").get<std::string>().substr(1)))
                          : use;
  if (plain.contains("anyOf")) return in_words_of_alternatives(plain);
  const Json type = plain.at("type").is_array() ? plain.at("type").at(0) : plain.at("type");
  if (type == "object") return "map";
  if (type == "boolean") return "true or false";
  if (type == "number") return ensonify::in_words(range_of(use), "number");
  if (type == "string") {
    const Json& length = use.contains("maxLength") ? use.at("maxLength") : plain.at("maxLength");
    return fmt::format("printable text of 1 to {} bytes", length.get<int>());
  }
  if (type == "integer") {
    return fmt::format("an integer from {} to {}", use.at("minimum").dump(),
                       use.at("maximum").dump());
  }
  const bool numbers = list_schema(plain.at("items")) == nullptr && plain.contains("maxItems");
  return numbers ? fmt::format("a list of {} numbers", plain.at("maxItems").dump()) : "a list";
}

using MapKey = std::pair<const Json*, std::string>;

std::string listed(const std::set<MapKey>& keys) {
  const auto paths = all_maps();
  std::string text;
  for (const auto& [map, key] : keys) text += joined_to(paths.at(map), key) + "\n";
  return text;
}

}  // namespace

// Protects writers of scenarios from an editor that marks what the program takes, and readers of
// data sets: the resolved text is a scenario too.
TEST_CASE("every scene and every example is as the schema says, resolved as well") {
  CHECK(samples().texts().size() > 25);
  for (const std::string& text : samples().texts()) {
    const auto scenario = parsed(text);
    INFO(text << (scenario.ok() ? "" : scenario.error().message));
    REQUIRE(scenario.ok());
    CHECK(schema_fault(json_of(text)) == "");
    const std::string resolved = emit(*scenario);
    INFO(resolved);
    CHECK(schema_fault(json_of(resolved)) == "");
  }
}

TEST_CASE("every preset is as the schema says") {
  for (const SonarPreset& preset : sonar_presets()) {
    INFO(preset.name);
    CHECK(schema_fault({{"ensonify", 1}, {"sonar", json_of(preset.yaml)}}) == "");
  }
}

// Protects against keys that only one of the two knows: the parser names those it accepts beside an
// unknown one.
TEST_CASE("the schema has the keys that the parser knows, in every map") {
  std::set<const Json*> seen;
  walk_samples([&](const std::string& text, const Json& map, const Json&, const std::string& path) {
    if (!seen.insert(&map).second || has_free_names(map)) return;
    const std::string wrong = joined_to(path, "qqqq");
    const std::string fault = fault_at(text, {{wrong, "1"}}, wrong);
    INFO(text << path << fault);
    const std::string listing = ", accepted are ";
    const std::size_t at = fault.find(listing);
    REQUIRE((at != std::string::npos || fault.ends_with("no key is accepted here")));
    auto known = at == std::string::npos ? std::set<std::string>{}
                                         : words_in(fault.substr(at + listing.size()));
    auto described = keys_of(map);
    const bool counted = &map == &schema().at("definitions").at("object") ||
                         &map == &schema().at("definitions").at("point_target");
    if (counted) CHECK(described.erase("count") == 1);
    CHECK(described == known);
  });
  for (const auto& [map, path] : all_maps()) {
    INFO("no sample has a map at " << path);
    CHECK(seen.contains(map));
  }
}

// Protects limits, words and kinds of values: a value of the wrong kind makes the parser say what
// it accepts.
TEST_CASE("the schema has the limits and words that the parser has") {
  std::set<MapKey> open, confirmed;
  std::map<MapKey, std::string> said;
  const auto check = [&](const MapKey& id, const std::string& text, const std::string& path,
                         const std::string& value, const std::string& at,
                         const std::string& expected) {
    if (confirmed.contains(id)) return;
    open.insert(id);
    const std::string fault = fault_at(text, {{path, value}}, at);
    said[id] += fault + ", not " + expected + "\n";
    if (fault.find(expected) != std::string::npos) confirmed.insert(id);
  };
  walk_samples([&](const std::string& text, const Json& map, const Json&, const std::string& path) {
    for (const std::string& key : keys_of(map)) {
      const Json& use = map.at("properties").at(key);
      const std::string at = joined_to(path, key);
      const std::string expected = in_words(use);
      check({&map, key}, text, at, expected == "a list" || expected == "map" ? "x" : "[]", at,
            expected);
      const Json* list = list_schema(use);
      if (list == nullptr || !expected.ends_with("numbers")) continue;
      Json words = Json::array();
      for (int i = 0; i < list->at("maxItems"); ++i) words.push_back("x");
      check({&map, key + ".0"}, text, at, words.dump(), at + ".0",
            ensonify::in_words(range_of(list->at("items")), "number"));
    }
  });
  for (const MapKey& id : confirmed) open.erase(id);
  for (const MapKey& id : open) UNSCOPED_INFO(said.at(id));
  CHECK(listed(open) == "");
  CHECK(confirmed.size() > 200);
}

// Protects from defaults in an editor that are not the program's: giving one changes nothing.
TEST_CASE("the schema's defaults are the parser's") {
  std::set<MapKey> open, confirmed;
  walk_samples(
      [&](const std::string& text, const Json& map, const Json& value, const std::string& path) {
        for (const std::string& key : keys_of(map)) {
          const Json& use = map.at("properties").at(key);
          const MapKey id{&map, key};
          if (!use.contains("default") || value.contains(key) || confirmed.contains(id)) continue;
          open.insert(id);
          const auto given = parsed(text, {{joined_to(path, key), use.at("default").dump()}});
          if (given.ok() && emit(*given) == emit(*parsed(text))) confirmed.insert(id);
        }
      });
  for (const MapKey& id : confirmed) open.erase(id);
  CHECK(listed(open) == "");
  CHECK(confirmed.size() > 40);
}

// Protects from a schema that is stricter than the program: whatever is done to a value, what the
// parser still takes, the schema takes.
TEST_CASE("the schema refuses nothing that the parser takes", "[figure]") {
  std::set<MapKey> seen;
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
      kHead + "volumes: [{name: v, uniform: {strength_db: 0}, pose: {}}]\n",
      kHead +
          "volumes: [{name: v, plume: {radius_m: 1, height_m: 1, strength_db: 0}, "
          "extinction_db_m: 1}]\n",
      kHead + "trajectory: {poses: []}\n",
      kHead + "trajectory: {poses: [{}, {}]}\n",
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

// Protects completion and the reference: every key is explained where it stands or where it is
// defined.
TEST_CASE("every key of the schema has a title and a description") {
  for (const auto& [map, path] : all_maps()) {
    for (const std::string& key : keys_of(*map)) {
      const Json* use = &map->at("properties").at(key);
      while (use->contains("$ref")) {
        use = &schema().at(Json::json_pointer(use->at("$ref").get<std::string>().substr(1)));
      }
      INFO(joined_to(path, key));
      CHECK(use->contains("title"));
      CHECK(use->contains("description"));
    }
  }
}

}  // namespace ensonify::testing
