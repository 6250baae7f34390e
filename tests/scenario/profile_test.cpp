#include "catch.h"
#include "scenario/tables.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

using namespace ensonify;
using namespace ensonify::testing;

namespace {

std::string told_of(const std::string& text) { return message_of(parse(text)); }

}  // namespace

TEST_CASE("a profile of rows is read and written as it stands") {
  const auto scenario =
      value_of(parse(kHead + "water: {sound_speed_m_s: 1490, profile: {depth_m: [0, 5, 20],\n"
                             "  sound_speed_m_s: [1520, 1500.5, 1490], surface_z_m: 3}}\n"));
  REQUIRE(scenario.water.profile);
  const ProfileSpec& profile = *scenario.water.profile;
  CHECK(profile.depth_m == std::vector<double>{0, 5, 20});
  CHECK(profile.sound_speed_m_s == std::vector<double>{1520, 1500.5, 1490});
  CHECK(profile.surface_z_m == 3);
  const std::string resolved = emit(scenario);
  CHECK(contains(resolved,
                 "  profile: {depth_m: [0, 5, 20], sound_speed_m_s: [1520, 1500.5, 1490], "
                 "surface_z_m: 3}\n"));
  const auto again = value_of(parse(resolved));
  CHECK(emit(again) == resolved);
  // Data sets without one keep their scenario.yaml.
  CHECK_FALSE(contains(emit(*parse(kHead)), "profile"));
}

TEST_CASE("a profile of a file is an input file") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("cast.csv", "depth_m, sound_speed_m_s\n0, 1520\n8, 1500\n");
  const auto scenario = value_of(
      parse_scenario(kHead + "water: {profile: {file: cast.csv}}\n", "t.yaml", folder.path()));
  CHECK(input_files(scenario) == std::vector<std::filesystem::path>{file});
  const auto profile = value_of(load_sound_profile(file));
  CHECK(profile.depth_m == std::vector<double>{0, 8});
  CHECK(profile.speed_m_s == std::vector<double>{1520, 1500});
  // Lists take the file's place, and the other way round.
  const auto lists = value_of(parse_scenario(
      kHead + "water: {profile: {file: cast.csv}}\n", "t.yaml", folder.path(),
      {{"water.profile.depth_m", "[0]"}, {"water.profile.sound_speed_m_s", "[1510]"}}));
  CHECK(lists.water.profile->file.empty());
}

TEST_CASE("wrong profiles say what is wrong and where") {
  const auto with = [](const std::string& profile) {
    return told_of(kHead + "water: {profile: " + profile + "}\n");
  };
  CHECK(contains(with("{depth_m: [0, 5, 5], sound_speed_m_s: [1500, 1500, 1500]}"),
                 "water.profile.depth_m.2: 5 is not below the 5 before it"));
  CHECK(contains(
      with("{depth_m: [0, 5], sound_speed_m_s: [1500]}"),
      "water.profile.sound_speed_m_s: the number of values is 1, but that of depth_m is 2"));
  CHECK(contains(with("{depth_m: [0], sound_speed_m_s: [99]}"), "`99` is out of range"));
  CHECK(contains(with("{depth_m: [], sound_speed_m_s: []}"),
                 "the list is empty; expected one row or more"));
  CHECK(contains(with("{depth: [0]}"), "depth_m"));
  CHECK(contains(with("{}"), "water.profile.depth_m: missing"));
  CHECK(contains(with("{file: none.csv}"), "none.csv"));
  const test::TemporaryFolder folder;
  const auto trouble = [&](const std::string& text) {
    return message_of(load_sound_profile(folder.write("p.csv", text)));
  };
  CHECK(trouble("depth_m,sound_speed_m_s\n0,1500\n") == "");
  CHECK(contains(trouble("depth_m,sound_speed_m_s\n"), "there are no rows"));
  CHECK(contains(trouble("depth_m,sound_speed_m_s\n3,1500\n2,1500\n"), "p.csv:3: 2 is not above"));
  CHECK(contains(trouble("depth_m,sound_speed_m_s\n3,15\n"),
                 "sound_speed_m_s: `15` is out of range"));
}

// Protects against echoes that would be wrong without a word.
TEST_CASE("what cannot stand beside a profile is refused where it stands") {
  const std::string head = kHead + "water: {profile: {depth_m: [0], sound_speed_m_s: [1510]}}\n";
  CHECK(contains(
      told_of(head + "materials: {m: {reflectivity: 1, coherent: {model: kirchhoff}}}\n"),
      "t.yaml:5:44: materials.m.coherent: specular echoes are not computed along refracted rays"));
  CHECK(told_of(head + "materials: {m: {reflectivity: 1, coherent: {model: rician, k: 1}}}\n") ==
        "");
  CHECK(contains(
      told_of(head +
              "volumes:\n  - {name: haze, uniform: {strength_db: -50, size_m: [1, 1, 1]}}\n"),
      "volumes.0: bounded volumes"));
  CHECK(told_of(head + "volumes:\n  - {name: haze, uniform: {strength_db: -50}}\n") == "");
  CHECK(contains(told_of(head + "multipath: {surface: {z_m: 2, reflection: -1}}\n"),
                 "t.yaml:5:12: multipath: multipath is not computed along refracted rays"));
  CHECK(contains(told_of(head + "motion_within_ping: true\n"),
                 "t.yaml:5:21: motion_within_ping: motion within a ping is not computed"));
  CHECK(told_of(head + "motion_within_ping: false\n") == "");
  CHECK(contains(told_of(head + "scattering: {speckle: surface}\n"),
                 "t.yaml:5:23: scattering.speckle: scatterers fixed on surfaces"));
  CHECK(told_of(head + "scattering: {speckle: per_ray}\n") == "");
}
