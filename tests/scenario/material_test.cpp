#include "catch.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using testing::check_single_faults;
using testing::emit;
using testing::faults_of;
using testing::kHead;
using testing::parse;
using testing::read_again;
using testing::tells;

// A scenario with one material `m`, its keys from line 4, column 17 on.
std::string with(const std::string& keys) { return kHead + "materials: {m: {" + keys + "}}\n"; }

MaterialSpec material_with(const std::string& keys, const std::vector<Override>& overrides = {}) {
  INFO(keys);
  const auto scenario = value_of(parse(with(keys), overrides));
  return scenario.materials.at(0);
}

TEST_CASE("a material's law is a word or a map of one") {
  for (const char* keys : {"reflectivity: 2", "reflectivity: 2, law: lambert",
                           "reflectivity: 2, law: {lambert: {}}"}) {
    const MaterialSpec material = material_with(keys);
    CHECK(material.reflectivity == 2);
    CHECK_FALSE(std::get<Lambert>(material.law).exponent);
    CHECK(std::holds_alternative<std::monostate>(material.coherent));
  }
  const MaterialSpec lambert = material_with("reflectivity: 2, law: {lambert: {exponent: 0}}");
  CHECK(std::get<Lambert>(lambert.law).exponent == 0);
  const MaterialSpec dust = material_with("reflectivity: 2, law: lommel_seeliger");
  CHECK(name_of(dust.law) == "lommel_seeliger");
  CHECK(dust.reflectivity == 2);
}

// Protects those who have strengths in dB from papers.
TEST_CASE("a backscattering strength stands for a reflectivity") {
  CHECK(material_with("backscatter_strength_db: -30").reflectivity == Approx(1e-3));
  CHECK(material_with("backscatter_strength_db: 0, law: lommel_seeliger").reflectivity == 1);
}

TEST_CASE("a material's coherent part is a model with its keys") {
  const MaterialSpec rician = material_with("reflectivity: 1, coherent: {model: rician, k: 0}");
  CHECK(std::get<RicianSpec>(rician.coherent).k == 0);
  const MaterialSpec plain = material_with("reflectivity: 1, coherent: {model: kirchhoff}");
  CHECK(std::get<KirchhoffSpec>(plain.coherent).reflection == 1);
  CHECK(std::get<KirchhoffSpec>(plain.coherent).roughness_rms_m == 0);
  const MaterialSpec rough = material_with(
      "reflectivity: 1, coherent: {model: kirchhoff, reflection: -1, roughness_rms_m: 1}");
  CHECK(std::get<KirchhoffSpec>(rough.coherent).reflection == -1);
  CHECK(std::get<KirchhoffSpec>(rough.coherent).roughness_rms_m == 1);
  CHECK_FALSE(std::get<KirchhoffSpec>(rough.coherent).roughness_correlation_m);
  CHECK_FALSE(std::get<KirchhoffSpec>(rough.coherent).edges);
  const MaterialSpec plate = material_with(
      "reflectivity: 1, coherent: {model: kirchhoff, roughness_rms_m: 1e-4, "
      "roughness_correlation_m: 2e-3, edges: true}");
  const Material made = material_of(plate, {});
  CHECK(made.roughness_correlation_m == 2e-3);
  CHECK(made.edges);
}

TEST_CASE("a wrong material is told with its place") {
  const std::string head = "materials: {m: {reflectivity: 1, ";
  const std::string coherent = head + "coherent: {";
  check_single_faults({
      {"materials: {m: {law: lambert}}", "4:16: materials.m:", "either reflectivity"},
      {"materials: {m: {law: lommel_seeliger}}", "4:16: materials.m:", "backscatter_strength_db"},
      {head + "backscatter_strength_db: 0}}", "4:34: materials.m:", "exclude each other"},
      {"materials: {m: {backscatter_strength_db: 61}}",
       "4:42: materials.m.backscatter_strength_db:", "from -200 to 60"},
      {head + "law: lamberts}}", "4:39: materials.m.law:", "did you mean lambert?"},
      {"materials: {m: {law: lamberts}}", "4:22: materials.m.law:", "did you mean lambert?"},
      {head + "law: {lambert: {n: 2}}}}", "4:50: materials.m.law.lambert.n:", "expected exponent"},
      {head + "law: {lambert: {exponent: -1}}}}",
       "4:60: materials.m.law.lambert.exponent:", "from 0 to 100"},
      {head + "law: {lambert: {}, lommel_seeliger: {}}}}",
       "4:53: materials.m.law:", "exclude each other"},
      {"materials: {m: {law: {table: {file: nowhere.csv}}}}",
       "4:37: materials.m.law.table.file:", "does not exist"},
      {"materials: {m: {law: table}}", "4:22: materials.m.law.table.file:", "missing"},
      {head + "coherence: 1}}", "4:34: materials.m.coherence:", "did you mean coherent?"},
      {head + "coherent: 1}}", "4:44: materials.m.coherent:", "expected a map with model"},
      {coherent + "k: 1}}}", "4:44: materials.m.coherent.model:", "one of rician, kirchhoff"},
      {coherent + "model: rice, k: 1}}}",
       "4:52: materials.m.coherent.model:", "one of rician, kirchhoff"},
      {coherent + "model: rician}}}", "4:44: materials.m.coherent.k:", "missing"},
      {coherent + "model: rician, k: -0.1}}}", "4:63: materials.m.coherent.k:", "from 0 to 1e+06"},
      {coherent + "model: rician, k: 1e7}}}", "4:63: materials.m.coherent.k:", "from 0 to 1e+06"},
      {coherent + "model: rician, k: 1, roughness_rms_m: 0.01}}}",
       "4:83: materials.m.coherent.roughness_rms_m:", "has no effect with model rician"},
      {coherent + "model: rician, k: 1, reflection: 1}}}",
       "4:78: materials.m.coherent.reflection:", "has no effect with model rician"},
      {coherent + "model: rician, k: 1, edges: true}}}",
       "4:73: materials.m.coherent.edges:", "has no effect with model rician"},
      {coherent + "model: kirchhoff, roughness_correlation_m: 0}}}",
       "4:88: materials.m.coherent.roughness_correlation_m:", "from 1e-05 to 10"},
      {coherent + "model: kirchhoff, roughness_rms_m: 0.2, roughness_correlation_m: 0.1}}}",
       "4:110: materials.m.coherent.roughness_correlation_m:", "expected at least roughness_rms_m"},
      {coherent + "model: kirchhoff, k: 1}}}",
       "4:66: materials.m.coherent.k:", "has no effect with model kirchhoff"},
      {coherent + "model: kirchhoff, reflection: 1.1}}}",
       "4:75: materials.m.coherent.reflection:", "from -1 to 1"},
      {coherent + "model: kirchhoff, roughness_rms_m: -1e-3}}}",
       "4:80: materials.m.coherent.roughness_rms_m:", "from 0 to 1"},
      {coherent + "model: kirchhoff, roughness_rms_m: 2}}}",
       "4:80: materials.m.coherent.roughness_rms_m:", "from 0 to 1"},
  });
}

// Protects measured strengths: a table needs no reflectivity, and takes none.
TEST_CASE("a law may be a table beside the scenario") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("sand.csv", "grazing_deg,strength_db\n");
  const auto in_folder = [&](const std::string& keys, const std::vector<Override>& overrides = {}) {
    return parse_scenario(with(keys), "t.yaml", folder.path(), overrides);
  };
  const auto table = in_folder("law: {table: {file: sand.csv}}, coherent: {model: rician, k: 1}");
  require_ok(table);
  CHECK(std::get<MeasuredStrength>(table->materials[0].law).file == file);
  CHECK(std::get<RicianSpec>(table->materials[0].coherent).k == 1);
  CHECK(name_of(material_of(table->materials[0], table->scattering).law) == "table");
  CHECK(input_files(*table) == std::vector{file});
  const auto name = [](const std::filesystem::path& path) { return path.filename().string(); };
  const std::string text = to_yaml(*table, name);
  CHECK(contains(text, "  m: {law: {table: {file: sand.csv}}, coherent: "));
  const auto again = value_of(parse_scenario(text, "t.yaml", folder.path()));
  CHECK(to_yaml(again, name) == text);

  const auto both = in_folder("reflectivity: 1, law: {table: {file: sand.csv}}");
  REQUIRE_FALSE(both.ok());
  CHECK(both.error().message.starts_with(
      "t.yaml:4:31: materials.m.reflectivity: has no effect with a table"));
  // An override that makes the law a table needs not remove the reflectivity.
  const auto replaced = value_of(in_folder("reflectivity: 1, law: {lambert: {exponent: 2}}",
                                           {{"materials.m.law.table.file", "sand.csv"}}));
  CHECK(name_of(replaced.materials[0].law) == "table");
  const auto useless =
      in_folder("law: {table: {file: sand.csv}}", {{"materials.m.reflectivity", "1"}});
  REQUIRE_FALSE(useless.ok());
  CHECK(useless.error().message.starts_with(
      "--set materials.m.reflectivity: materials.m.reflectivity: has no effect"));
}

TEST_CASE("an override changes a law or a coherent part") {
  const std::string kirchhoff =
      "reflectivity: 1, coherent: {model: kirchhoff, reflection: 0.5, roughness_rms_m: 0.1}";
  const MaterialSpec rician = material_with(
      kirchhoff, {{"materials.m.coherent.model", "rician"}, {"materials.m.coherent.k", "2"}});
  CHECK(std::get<RicianSpec>(rician.coherent).k == 2);
  const MaterialSpec whole =
      material_with(kirchhoff, {{"materials.m.coherent", "{model: rician, k: 3}"}});
  CHECK(std::get<RicianSpec>(whole.coherent).k == 3);
  const MaterialSpec back = material_with("reflectivity: 1, coherent: {model: rician, k: 1}",
                                          {{"materials.m.coherent.model", "kirchhoff"}});
  CHECK(std::get<KirchhoffSpec>(back.coherent).reflection == 1);
  const MaterialSpec stronger = material_with("reflectivity: 1, coherent: {model: rician, k: 1}",
                                              {{"materials.m.coherent.k", "7"}});
  CHECK(std::get<RicianSpec>(stronger.coherent).k == 7);
  const MaterialSpec word =
      material_with("reflectivity: 1, law: lambert", {{"materials.m.law.lambert.exponent", "2"}});
  CHECK(std::get<Lambert>(word.law).exponent == 2);
  const MaterialSpec other = material_with("reflectivity: 1, law: {lambert: {exponent: 2}}",
                                           {{"materials.m.law", "lommel_seeliger"}});
  CHECK(name_of(other.law) == "lommel_seeliger");
  // Names of materials are the user's own, whatever keys they resemble.
  const auto names = value_of(parse(kHead, {{"materials.law.reflectivity", "1"},
                                            {"materials.table.reflectivity", "1"},
                                            {"materials.lambert.law", "lambert"},
                                            {"materials.lambert.reflectivity", "1"}}));
  CHECK(names.materials.size() == 3);

  const auto no_model = faults_of(with("reflectivity: 1"), {{"materials.m.coherent.k", "1"}});
  CHECK(no_model.size() == 1);
  CHECK(tells(no_model, "--set materials.m.coherent.k: materials.m.coherent.model:", "missing"));
  const auto other_model = faults_of(with(kirchhoff), {{"materials.m.coherent.k", "1"}});
  CHECK(other_model.size() == 1);
  CHECK(tells(other_model, "--set materials.m.coherent.k: ", "has no effect with model kirchhoff"));
}

TEST_CASE("a mesh may bring its reflectivity in vertex colours or an image") {
  const test::TemporaryFolder folder;
  folder.write("a.ply", "ply\n");
  folder.write("a.png", "");
  const auto with_mesh = [&](const std::string& keys) {
    return parse_scenario(kHead +
                              "materials: {m: {reflectivity: 1}}\nobjects: [{name: a, material: "
                              "m, shape: {mesh: {file: a.ply" +
                              keys + "}}}]\n",
                          "t.yaml", folder.path());
  };
  for (const auto& [keys, from_vertices] :
       {std::pair{"", false}, std::pair{", reflectivity: material", false},
        std::pair{", reflectivity: vertex_color", true}}) {
    const auto scenario = value_of(with_mesh(keys));
    CHECK(std::get<MeshSpec>(scenario.objects[0].shape).vertex_reflectivity == from_vertices);
    CHECK(contains(emit(scenario),
                   from_vertices ? "reflectivity: vertex_color}" : "reflectivity: material}"));
  }
  const auto scenario = value_of(with_mesh(", reflectivity: texture, texture_file: a.png"));
  const auto& mesh = std::get<MeshSpec>(scenario.objects[0].shape);
  CHECK(mesh.texture_file == folder.path() / "a.png");
  CHECK_FALSE(mesh.vertex_reflectivity);
  CHECK(input_files(scenario) == std::vector{folder.path() / "a.ply", folder.path() / "a.png"});
  read_again(scenario, folder.path());
  for (const auto& [keys, told] :
       {std::pair{", reflectivity: vertex_colour", "did you mean vertex_color?"},
        std::pair{", reflectivity: texture", "objects.0.shape.mesh.texture_file: missing"},
        std::pair{", texture_file: a.png", "has no effect without reflectivity: texture"},
        std::pair{", reflectivity: vertex_color, texture_file: a.png",
                  "has no effect without reflectivity: texture"},
        std::pair{", reflectivity: texture, texture_file: a.jpg",
                  "expected a readable file ending in .png"}}) {
    check_fails(with_mesh(keys), {told});
  }
  const auto unknown = with_mesh(", reflectivity: txture, texture_file: a.png");
  check_fails(unknown, {"t.yaml:5:76: objects.0.shape.mesh.reflectivity: "});
  CHECK_FALSE(contains(unknown.error().message, "has no effect"));
}

TEST_CASE("volumes are instances with a strength") {
  const auto scenario =
      value_of(parse(kHead + "volumes:\n  - {name: water, uniform: {strength_db: -60}}\n"
                             "  - {name: cloud, class: plankton, uniform: {strength_db: 60}}\n"));
  REQUIRE(scenario.volumes.size() == 2);
  CHECK(scenario.volumes[0].name == "water");
  CHECK(scenario.volumes[0].class_name == "volume");
  CHECK(std::get<UniformVolumeSpec>(scenario.volumes[0].kind).strength_db == -60);
  CHECK(scenario.volumes[1].class_name == "plankton");
  const std::string strength = "uniform: {strength_db: -60}}";
  check_single_faults({
      {"volumes: {name: a}", "4:10: volumes:", "expected a list"},
      {"volumes: [{" + strength + "]", "4:11: volumes.0.name:", "missing"},
      {"volumes: [{name: a}]", "4:11: volumes.0:", "one of uniform, vdb, plume, school"},
      {"volumes: [{name: a, uniform: -60}]", "4:30: volumes.0.uniform:", "a map with strength_db"},
      {"volumes: [{name: a, uniform: {strength_db: 61}}]",
       "4:44: volumes.0.uniform.strength_db:", "from -200 to 60"},
      {"volumes: [{name: a, uniform: {strength_db: -201}}]",
       "4:44: volumes.0.uniform.strength_db:", "from -200 to 60"},
      {"volumes: [{name: a, " + strength + ", {name: a, " + strength + "]",
       "4:58: volumes.1.name:", "the name `a` is already used by volumes.0.name"},
      {"point_targets: [{name: a, target_strength_db: 0, position_m: [0, 0, 0]}]\n"
       "volumes: [{name: a, " +
           strength + "]",
       "5:18: volumes.0.name:", "the name `a` is already used by point_targets.0.name"},
  });
}

TEST_CASE("noise is a spectrum level or a ratio") {
  const auto ratio = value_of(parse(kHead + "noise: {snr_db: -3.5}\n"));
  CHECK(ratio.noise_snr_db == -3.5);
  CHECK_FALSE(ratio.noise_spectrum_level_db);
  const auto replaced =
      value_of(parse(kHead + "noise: {snr_db: 20}\n", {{"noise.spectrum_level_db", "30"}}));
  CHECK(replaced.noise_spectrum_level_db == 30);
  CHECK_FALSE(replaced.noise_snr_db);
  check_single_faults({
      {"noise: {snr_db: 20, spectrum_level_db: 30}", "4:21: noise:", "exclude each other"},
      {"noise: {snr_db: 201}", "4:17: noise.snr_db:", "from -100 to 200"},
      {"noise: {snr_db: -101}", "4:17: noise.snr_db:", "from -100 to 200"},
      {"noise: {spectrum_level_db: 301}", "4:28: noise.spectrum_level_db:", "from -300 to 300"},
  });
}

}  // namespace
}  // namespace ensonify
