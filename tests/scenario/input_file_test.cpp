#include <cstdlib>
#include <fstream>

#include "catch.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using test::TemporaryFolder;
using testing::emit;
using testing::kHead;

std::string with_mesh(const std::string& file) {
  return kHead +
         "materials: {m: {reflectivity: 1}}\nobjects: [{name: a, material: m, shape: {mesh: "
         "{file: " +
         file + "}}}]\n";
}

// Protects whoever runs a stranger's scenario: what it reads of his own is told, by link as well.
TEST_CASE("input files outside the scenario's folder are told") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "mine/meshes");
  folder.write("other.obj", "v 0 0 0\n");
  folder.write("mine/meshes/own.obj", "v 0 0 0\n");
  std::filesystem::create_symlink(folder.path() / "other.obj", folder.path() / "mine/link.obj");
  const auto notices = [&](const std::string& file) {
    const auto scenario =
        value_of(parse_scenario(with_mesh(file), "t.yaml", folder.path() / "mine"));
    return scenario.notices;
  };
  CHECK(notices("meshes/own.obj").empty());
  CHECK(notices("meshes/../../mine/meshes/own.obj").empty());
  const std::string other = std::filesystem::canonical(folder.path() / "other.obj").string();
  const std::vector<std::string> told = {
      other + " is outside the folder of the scenario; its contents are copied into the data set"};
  CHECK(notices("../other.obj") == told);
  CHECK(notices(other) == told);
  CHECK(notices("link.obj") == told);
}

// Protects the promise that nothing is generated before every input is known to be there.
TEST_CASE("input files that are missing or no files are faults at their place") {
  const TemporaryFolder folder;
  folder.write("a.obj", "v 0 0 0\n");
  folder.write("a.txt", "x");
  std::filesystem::create_directory(folder.path() / "d.obj");
  const auto message = [&](const std::string& file) {
    return message_of(parse_scenario(with_mesh(file), "t.yaml", folder.path()));
  };
  const std::string place = "t.yaml:5:55: objects.0.shape.mesh.file: `";
  CHECK(message("a.obj").empty());
  CHECK(message("b.obj").starts_with(place + "b.obj` does not exist"));
  CHECK(message("d.obj").starts_with(place + "d.obj` is a folder"));
  CHECK(message("a.txt").starts_with(place + "a.txt` has another extension"));
  CHECK(message("a.txt").ends_with(".obj, .stl, .ply, .dae, .glb, .gltf"));
  CHECK(message("\"a\\0.obj\"").starts_with(place + "a\\x00.obj` contains a control character"));
  CHECK(message("7").starts_with("t.yaml:5:55: objects.0.shape.mesh.file: `7` is a number"));
  if (geteuid() != 0) {  // nothing is unreadable to root
    std::filesystem::permissions(folder.path() / "a.obj", std::filesystem::perms::none);
    CHECK(message("a.obj").starts_with(place + "a.obj` cannot be read"));
  }
}

// Protects the rule that paths are relative to the scenario file, and that each input is listed
// once, in the order in which it appears.
TEST_CASE("input files are found beside the scenario and listed once") {
  const TemporaryFolder folder;
  folder.write("a.obj", "v 0 0 0\n");
  folder.write("B.STL", "solid\n");
  folder.write("path.csv", "0,0,0,0\n");
  folder.write("s.yaml",
               kHead +
                   "materials: {m: {reflectivity: 1}}\nobjects:\n"
                   "- {name: x, material: m, shape: {mesh: {file: ./B.STL, normals: smooth}}}\n"
                   "- {name: y, material: m, shape: {mesh: {file: a.obj, scale: 1e-3}}}\n"
                   "- {name: z, material: m, shape: {mesh: {file: B.STL}}}\n"
                   "trajectory: {file: path.csv}\n");
  const auto loaded = value_of(load_scenario(folder.path() / "s.yaml"));
  const std::vector<std::filesystem::path> expected = {
      folder.path() / "B.STL", folder.path() / "a.obj", folder.path() / "path.csv"};
  CHECK(input_files(loaded) == expected);
  CHECK_FALSE(loaded.trajectory.pings);
  CHECK(std::get<MeshSpec>(loaded.objects[0].shape).smooth_normals);
  CHECK(std::get<MeshSpec>(loaded.objects[1].shape).scale ==
        std::array<double, 3>{1e-3, 1e-3, 1e-3});

  const auto relative = [](const std::filesystem::path& file) { return file.filename().string(); };
  const std::string text = to_yaml(loaded, relative);
  CHECK_FALSE(contains(text, folder.path().string()));
  const auto again = value_of(parse_scenario(text, "again", folder.path()));
  CHECK(to_yaml(again, relative) == text);
}

// Protects the exit status: a scenario that is not there is wrong usage.
TEST_CASE("a scenario file that cannot be read is an error with its name") {
  const TemporaryFolder folder;
  check_fails(load_scenario(folder.path() / "none.yaml"), ErrorKind::usage,
              {"none.yaml: no such file"});
  CHECK(contains(message_of(load_scenario(folder.path())), "is a folder"));
  folder.write("big.yaml", std::string((16u << 20) + 1, '#'));
  CHECK(contains(message_of(load_scenario(folder.path() / "big.yaml")), "larger than 16 MiB"));
  folder.write("bad.yaml", kHead + "wter: 1\n");
  const auto bad = load_scenario(folder.path() / "bad.yaml");
  REQUIRE_FALSE(bad.ok());
  CHECK(bad.error().kind == ErrorKind::usage);
  CHECK(bad.error().message.starts_with((folder.path() / "bad.yaml").string() + ":4:1: wter: "));
}

}  // namespace
}  // namespace ensonify
