// Materials by name: taken from configs/materials.yaml where the scenario defines none, and as
// presets under its own keys.
#include <cmath>

#include "catch.h"
#include "results.h"
#include "scenario/scenario.h"

using namespace ensonify;

namespace {

Result<Scenario> parsed(const std::string& materials, const std::string& material) {
  return parse_scenario("ensonify: 1\nsonar: {preset: blueview_p900_90}\n" + materials +
                            "objects:\n  - {name: ball, material: " + material +
                            ", shape: {sphere: {radius_m: 1}}}\n",
                        "a.yaml", ".");
}

const MaterialSpec& material(const Scenario& scenario, const std::string& name) {
  for (const MaterialSpec& spec : scenario.materials) {
    if (spec.name == name) return spec;
  }
  FAIL(name);
  return scenario.materials.front();
}

}  // namespace

TEST_CASE("a material that is not defined is that of its name") {
  const auto scenario = value_of(parsed("", "sand_fine"));
  REQUIRE(scenario.materials.size() == 1);
  CHECK(material(scenario, "sand_fine").reflectivity == Approx(std::pow(10, -2.5)));
  CHECK(material(scenario, "sand_fine").texture->model == TextureModel::gamma);
  // Its field is sampled for each sequence.
  CHECK(varies_by_sequence(scenario));
  // The resolved text stands alone.
  const auto again = value_of(parse_scenario(
      to_yaml(scenario, [](const auto& file) { return file.string(); }), "again.yaml", "."));
  CHECK(material(again, "sand_fine").reflectivity == material(scenario, "sand_fine").reflectivity);
}

TEST_CASE("the scenario's own material of the name wins") {
  const auto scenario =
      value_of(parsed("materials: {sand_fine: {reflectivity: 0.5}}\n", "sand_fine"));
  CHECK(material(scenario, "sand_fine").reflectivity == 0.5);
  CHECK_FALSE(material(scenario, "sand_fine").texture);
  CHECK_FALSE(varies_by_sequence(scenario));
}

TEST_CASE("a preset lies under the keys of a material") {
  const auto scenario =
      value_of(parsed("materials: {hull: {preset: steel_rusty, reflectivity: 0.1}}\n", "hull"));
  const MaterialSpec& hull = material(scenario, "hull");
  CHECK(hull.reflectivity == 0.1);
  CHECK(std::get<KirchhoffSpec>(hull.coherent).reflection == 0.94);
  CHECK(hull.texture->shape == 2);
}

TEST_CASE("a wall replaces the reflection of a preset") {
  const std::string wall =
      "{thickness_m: 0.003, density_kg_m3: 7850, speed_m_s: 5900, shear_speed_m_s: 3230, "
      "filling: air}";
  const auto scenario =
      value_of(parsed("materials: {drum: {preset: steel_rusty, wall: " + wall + "}}\n", "drum"));
  const MaterialSpec& drum = material(scenario, "drum");
  REQUIRE(drum.wall);
  CHECK(drum.wall->shear_speed_m_s == 3230);
  CHECK(drum.wall->loss == 0.01);
  CHECK_FALSE(drum.wall->water_inside);
  CHECK(has_walls(scenario));
  CHECK(material_of(drum, scenario.scattering).reflection == 1);
  check_fails(parsed("materials: {drum: {reflectivity: 1, coherent: {model: kirchhoff, "
                     "reflection: 0.9}, wall: " +
                         wall + "}}\n",
                     "drum"),
              {"coherent.reflection"});
  check_fails(
      parsed("materials: {drum: {reflectivity: 1, coherent: {model: kirchhoff, edges: true, "
             "roughness_correlation_m: 0.01}, wall: " +
                 wall + "}}\n",
             "drum"),
      {"coherent.edges: has no effect with a wall", "coherent.roughness_correlation_m"});
}

TEST_CASE("a wall that no solid can be is an error") {
  check_fails(
      parsed("materials: {a: {reflectivity: 1, wall: {thickness_m: 0.003, density_kg_m3: 1000, "
             "speed_m_s: 1500, shear_speed_m_s: 1400}}}\n",
             "a"),
      {"shear_speed_m_s"});
  check_fails(
      parsed("materials: {a: {reflectivity: 1, wall: {thickness_m: 0.003, density_kg_m3: 1000, "
             "speed_m_s: 1500}}}\nmultipath: {surface: {z_m: 2, reflection: -1}}\n",
             "a"),
      {"multipath"});
}

TEST_CASE("materials of choices, parts and growth are known too") {
  const auto drawn = value_of(parsed("", "{choice: [gravel, rock]}"));
  CHECK(drawn.materials.size() == 2);
  const auto grown = value_of(
      parsed("materials: {pile: {reflectivity: 0.01, growth: {material: mussels, cover: 0.4, "
             "correlation_m: 0.1}}}\n",
             "pile"));
  CHECK(material(grown, "mussels").reflectivity == Approx(0.1));
  CHECK(material(grown, "pile").growth->cover == 0.4);
}

// Protects those who sample a material: a preset was once ignored where it was sampled.
TEST_CASE("a preset may be sampled") {
  const std::string text =
      "ensonify: 1\nsonar: {preset: blueview_p900_90}\n"
      "materials: {body: {preset: {choice: [steel_smooth, rubber]}}}\n"
      "objects: [{name: ball, material: body, shape: {sphere: {radius_m: 1}}}]\n";
  int smooth = 0;
  for (std::uint32_t sequence = 0; sequence < 16; ++sequence) {
    const auto scenario = value_of(parse_scenario(text, "a.yaml", ".", {}, {sequence}));
    const auto metal = parsed("", "steel_smooth"), rubber = parsed("", "rubber");
    const MaterialSpec& body = material(scenario, "body");
    const bool is_metal = body.reflectivity == material(*metal, "steel_smooth").reflectivity;
    CHECK((is_metal || body.reflectivity == material(*rubber, "rubber").reflectivity));
    if (is_metal) CHECK(std::holds_alternative<KirchhoffSpec>(body.coherent));
    smooth += is_metal;
  }
  CHECK(smooth > 2);
  CHECK(smooth < 14);
  CHECK(check_draws(text, "a.yaml", ".", {}));
}

TEST_CASE("unknown materials and presets are errors with advice") {
  check_fails(parsed("", "sand_fin"), {"did you mean sand_fine?", "ensonify presets materials"});
  check_fails(parsed("materials: {hull: {preset: steel}}\n", "hull"),
              {"materials.hull.preset", "steel_smooth"});
  check_fails(parsed("materials: {a: {reflectivity: 1, growth: {material: a, cover: 0.5, "
                     "correlation_m: 1}}}\n",
                     "a"),
              {"growth.material"});
}

TEST_CASE("every material that is built in can be read") {
  const std::string text(materials_yaml());
  int count = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at), colon = text.find(':', at);
    if (text[at] != '#' && text[at] != ' ' && colon < end) {
      const auto scenario = parsed("", text.substr(at, colon - at));
      CHECK(scenario.ok());
      ++count;
    }
    at = end + 1;
  }
  CHECK(count >= 15);
}
