// Volumes of every kind: what is read, what is written, what is refused.
#include "catch.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using testing::check_single_faults;
using testing::kHead;
using testing::parse;

const std::string kVolumes =
    "volumes:\n"
    "  - {name: haze, uniform: {strength_db: -60}, extinction_db_m: 0.1}\n"
    "  - {name: box, uniform: {strength_db: -50, size_m: [1, 2, 3]}, pose: {position_m: [4, 5, "
    "6]}}\n"
    "  - {name: cloud, vdb: {file: a.vdb, strength_db: -40, extinction_db_m: 2}}\n"
    "  - {name: smoke, class: smoke, vdb: {file: ./a.vdb, grid: smoke 2, strength_db: -41}}\n"
    "  - {name: plume, plume: {radius_m: 0.2, height_m: 3, strength_db: -30}}\n"
    "  - {name: jet, plume: {radius_m: 0.1, height_m: 2, spread_deg: 12.5, strength_db: -20, "
    "extinction_db_m: 4}, pose: {rotation_deg: [0, 90, 0]}}\n"
    "  - {name: herring, school: {size_m: [4, 3, 2], fish: 500, target_strength_db: -45}}\n"
    "  - {name: krill, uniform: {strength_db: -70, patches: {model: lognormal, spread_db: 3, "
    "correlation_m: 2.5}}}\n";

}  // namespace

TEST_CASE("volumes of every kind are read") {
  const test::TemporaryFolder folder;
  folder.write("a.vdb", "");
  const auto scenario = value_of(parse_scenario(kHead + kVolumes, "t.yaml", folder.path()));
  const auto& volumes = scenario.volumes;
  REQUIRE(volumes.size() == 8);
  const auto& haze = std::get<UniformVolumeSpec>(volumes[0].kind);
  CHECK(haze.extinction_db_m == 0.1);
  CHECK_FALSE(haze.size_m);
  const auto& box = std::get<UniformVolumeSpec>(volumes[1].kind);
  CHECK(box.size_m == std::array<double, 3>{1, 2, 3});
  CHECK(box.extinction_db_m == 0);
  CHECK(volumes[1].pose.position_m == std::array<double, 3>{4, 5, 6});
  const auto& cloud = std::get<VdbVolumeSpec>(volumes[2].kind);
  CHECK(cloud.grid == "density");
  CHECK(cloud.extinction_db_m == 2);
  CHECK(std::get<VdbVolumeSpec>(volumes[3].kind).grid == "smoke 2");
  CHECK(std::get<PlumeSpec>(volumes[4].kind).spread_deg == 5);
  CHECK(std::get<PlumeSpec>(volumes[5].kind).extinction_db_m == 4);
  CHECK(std::get<SchoolSpec>(volumes[6].kind).fish == 500);
  CHECK_FALSE(haze.patches);
  const auto& krill = std::get<UniformVolumeSpec>(volumes[7].kind);
  REQUIRE(krill.patches);
  CHECK(krill.patches->model == TextureModel::lognormal);
  CHECK(krill.patches->spread_db == 3);
  CHECK(krill.patches->correlation_m == 2.5);
  CHECK(input_files(scenario) == std::vector{folder.path() / "a.vdb"});
}

// Protects sequences and sweep runs from sharing the patches of the first one.
TEST_CASE("volumes that are sampled differ between sequences") {
  const auto varies = [](const std::string& volume) {
    const auto scenario =
        value_of(parse_scenario(kHead + "volumes: [{name: w, " + volume + "}]\n", "t.yaml", "."));
    return varies_by_sequence(scenario);
  };
  CHECK_FALSE(varies("uniform: {strength_db: -60}"));
  CHECK(varies("uniform: {strength_db: -60, patches: {model: gamma, shape: 2, correlation_m: 1}}"));
  CHECK(varies("plume: {radius_m: 0.2, height_m: 3, strength_db: -30}"));
}

// Protects the identity of a data set, and the way of its files into it.
TEST_CASE("volumes are written as they are read") {
  const test::TemporaryFolder folder;
  folder.write("a.vdb", "");
  const auto name = [](const std::filesystem::path& file) { return file.filename().string(); };
  const auto scenario = value_of(parse_scenario(kHead + kVolumes, "t.yaml", folder.path()));
  const std::string text = to_yaml(scenario, name);
  CHECK(contains(text, "spread_deg: 12.5"));
  CHECK(contains(text, "fish: 500"));
  CHECK(contains(text, "patches: {model: lognormal, spread_db: 3, correlation_m: 2.5}"));
  const auto again = parse_scenario(text, "again.yaml", folder.path());
  INFO((again.ok() ? text : again.error().message));
  REQUIRE(again.ok());
  CHECK(to_yaml(*again, name) == text);
  CHECK(std::get<VdbVolumeSpec>(again->volumes[3].kind).grid == "smoke 2");
}

TEST_CASE("an override puts one kind of volume in another's place") {
  const auto scenario = value_of(
      parse(kHead + "volumes: [{name: a, uniform: {strength_db: -60}}]\n",
            {{"volumes.0.school", "{size_m: [1, 1, 1], fish: 3, target_strength_db: -40}"}}));
  CHECK(std::holds_alternative<SchoolSpec>(scenario.volumes[0].kind));
}

TEST_CASE("wrong volumes are refused where they stand") {
  const std::string begin = "volumes: [{name: a, ";
  check_single_faults({
      {begin + "uniform: {strength_db: 0}, school: {}}]",
       "4:48: volumes.0:", "uniform, school exclude each other; expected one of"},
      {begin + "unifrm: {strength_db: 0}, uniform: {strength_db: 0}}]",
       "4:21: volumes.0.unifrm:", "did you mean uniform?"},
      {begin + "uniform: {strength_db: 0}, pose: {}}]",
       "4:54: volumes.0.pose:", "which is infinite"},
      {begin + "uniform: {strength_db: 0, size_m: [1, 2]}}]",
       "4:55: volumes.0.uniform.size_m:", "3 numbers"},
      {begin + "uniform: {strength_db: 0, size_m: [1, 2, 0]}}]",
       "4:62: volumes.0.uniform.size_m.2:", "> 0"},
      {begin + "uniform: {strength_db: 0}, extinction_db_m: -1}]",
       "4:65: volumes.0.extinction_db_m:", "from 0 to"},
      {begin + "uniform: {strength_db: 0, patches: {model: gamma, correlation_m: 1}}}]",
       "4:56: volumes.0.uniform.patches.shape:", "missing"},
      {begin +
           "uniform: {strength_db: 0, patches: {model: gamma, shape: 2, correlation_m: 0.01}}}]",
       "4:96: volumes.0.uniform.patches.correlation_m:", "from 0.05 to 1000"},
      {begin + "uniform: {strength_db: 0, patches: {model: gamma, shape: 2}}}]",
       "4:56: volumes.0.uniform.patches.correlation_m:", "missing"},
      {begin + "uniform: {strength_db: 0, patches: {model: gamma, shape: 2, spread_db: 1, "
               "correlation_m: 1}}}]",
       "4:92: volumes.0.uniform.patches.spread_db:", "has no effect with model gamma"},
      {begin + "vdb: {strength_db: 0}}]", "4:26: volumes.0.vdb.file:", "missing"},
      {begin + "vdb: {file: none.vdb, strength_db: 0}}]",
       "4:33: volumes.0.vdb.file:", "does not exist"},
      {begin + "vdb: {file: a.obj, strength_db: 0}}]", "4:33: volumes.0.vdb.file:",
       "has another extension; expected a readable file ending in .vdb"},
      {begin + "plume: {radius_m: 1, height_m: 2}}]",
       "4:28: volumes.0.plume.strength_db:", "missing"},
      {begin + "plume: {radius_m: 1, height_m: 1001, strength_db: 0}}]",
       "4:52: volumes.0.plume.height_m:", "more than 1000 times radius_m"},
      {begin + "plume: {radius_m: 1, height_m: 2, spread_deg: 61, strength_db: 0}}]",
       "4:67: volumes.0.plume.spread_deg:", "from 0 to 60"},
      {begin + "plume: {radius_m: 1, height_m: 2, strength_db: 0}, extinction_db_m: 1}]",
       "4:89: volumes.0.extinction_db_m:", "among the keys of the kind of the volume"},
      {begin + "school: {size_m: [1, 1, 1], fish: 0, target_strength_db: 0}}]",
       "4:55: volumes.0.school.fish:", "1 to 100000"},
      {begin + "school: {size_m: [1, 1, 1], fish: 2, target_strength_db: 0}, "
               "extinction_db_m: 1}]",
       "4:99: volumes.0.extinction_db_m:", "fish do not attenuate"},
  });
}

}  // namespace ensonify
