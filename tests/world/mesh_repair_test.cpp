#include <cstring>
#include <limits>

#include "catch.h"
#include "is_refused.h"
#include "scenario/scenario.h"
#include "scenes.h"
#include "temporary_folder.h"
#include "world/import/import.h"
#include "world/world.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

const char* kPlyHead =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n";
const char* kPlyRows =
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
    "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

template <class T>
void put(std::string& bytes, T value, bool big_endian) {
  std::string raw(sizeof(T), '\0');
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes += big_endian ? std::string(raw.rbegin(), raw.rend()) : raw;
}

constexpr float kCorners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
constexpr int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

std::string binary_ply(bool big_endian) {
  std::string bytes = kPlyHead;
  bytes.replace(bytes.find("ascii"), 5, big_endian ? "binary_big_endian" : "binary_little_endian");
  for (const auto& corner : kCorners) {
    for (const float x : corner) put(bytes, x, big_endian);
  }
  for (const auto& face : kFaces) {
    bytes += '\3';
    for (const int v : face) put(bytes, v, big_endian);
  }
  return bytes;
}

std::string binary_stl(float first_x = 0) {
  std::string bytes(80, '\0');
  put(bytes, 4, false);
  for (const auto& face : kFaces) {
    bytes.append(12, '\0');
    for (const int v : face) {
      for (const float x : kCorners[v]) put(bytes, x, false);
    }
    bytes.append(2, '\0');
  }
  std::memcpy(bytes.data() + 96, &first_x, 4);
  return bytes;
}

std::string ascii_stl() {
  std::string text = "solid x\n";
  for (const auto& face : kFaces) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int v : face) {
      text += "vertex";
      for (const float x : kCorners[v]) text += x > 0 ? " 1" : " 0";
      text += "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid x\n";
}

}  // namespace

// Protects whoever copies large files over a bad line: wherever a file of these kinds is cut, it is
// refused by name, and neither read as a smaller mesh nor handed to a reader that stops the
// process.
TEST_CASE("a file that is cut off is refused wherever it is cut") {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> files = {
      {"a.ply", std::string(kPlyHead) + kPlyRows},
      {"little.ply", binary_ply(false)},
      {"big.ply", binary_ply(true)},
      {"b.stl", binary_stl()},
      {"a.stl", ascii_stl()}};
  for (const auto& [name, bytes] : files) {
    for (const Normals normals : {Normals::face, Normals::smooth}) {
      const auto whole = load_mesh(folder.write(name, bytes), {1, 1, 1}, normals);
      INFO(name << (whole.ok() ? "" : whole.error().message));
      REQUIRE(whole.ok());
      CHECK(whole->triangles.size() == 4);
      CHECK(whole->warnings.empty());
    }
    // The line's end and the name behind endsolid may be missing; digits are told by nothing.
    const std::size_t needed = bytes.size() - (name == "a.stl" ? 3 : name == "a.ply" ? 2 : 0);
    for (std::size_t length = 1; length < needed; length += 3) {
      INFO(name << " cut to " << length << " of " << bytes.size());
      // Without the importer's process: hundreds of them would take minutes.
      const auto cut = import_mesh(folder.write(name, bytes.substr(0, length)), {1, 1, 1}, Normals::smooth,
                                   MeshReflectivity::material);
      CHECK(is_refused(cut, name, ErrorKind::usage));
    }
  }
}

TEST_CASE("a cut file says where it ends") {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& name, const std::string& text) {
    return load_mesh(folder.write(name, text), {1, 1, 1}, Normals::face).error().message;
  };
  const std::string ply = std::string(kPlyHead) + kPlyRows;
  CHECK(message("f.ply", ply.substr(0, ply.size() - 10))
            .find("ends at face 2 of 4; the file is cut off") != std::string::npos);
  CHECK(message("v.ply", std::string(kPlyHead) + "0 0 0\n1 0 0\n0 ")
            .find("ends at vertex 2 of 4; the file is cut off") != std::string::npos);
  const std::string stl = ascii_stl();
  CHECK(message("s.stl", stl.substr(0, stl.find("endsolid"))).find("without endsolid") !=
        std::string::npos);
}

TEST_CASE("vertices that are not finite are refused in binary files too") {
  const TemporaryFolder folder;
  for (const float x :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    const auto mesh = load_mesh(folder.write("n.stl", binary_stl(x)), {1, 1, 1}, Normals::face);
    CHECK(is_refused(mesh, "not a finite number"));
  }
}

// Protects images from faces whose normal is noise, and users from repairs that they hear nothing
// of: what is left out is counted, what is thin but real stays.
TEST_CASE("faces without area are left out with a warning") {
  const TemporaryFolder folder;
  const std::string corners =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nv 0 0 0\n"
      "v 0.1 0.2 0.3\nv 0.2 0.4 0.6\nv 0.3 0.6 0.9\nv 0.5 1e-5 0\n";
  const std::string broken =
      "f 1 1 2\n"   // a corner twice
      "f 1 5 2\n"   // two corners in one place
      "f 1 2 4\n"   // in a line along an axis
      "f 6 7 8\n";  // in a line, but for rounding
  const auto file =
      folder.write("a.obj", corners + "f 1 2 3\n" + broken + "f 1 2 9\n");  // the last: 10 um thin
  for (const Normals normals : {Normals::face, Normals::smooth}) {
    const auto mesh = load_mesh(file, {1000, 1000, 1000}, normals);
    REQUIRE(mesh.ok());
    CHECK(mesh->triangles.size() == 2);
    REQUIRE(mesh->warnings.size() == 1);
    CHECK(mesh->warnings[0].find("a.obj: ignored 4 of 6 faces: they have zero area") !=
          std::string::npos);
    for (const auto& triangle : mesh->triangles) {
      for (const std::uint32_t v : triangle) CHECK(v < mesh->vertices.size());
    }
  }
  const auto nothing = load_mesh(folder.write("n.obj", corners + broken), {1, 1, 1}, Normals::face);
  CHECK(is_refused(nothing, "all its faces have zero area"));
}

// Protects against an OBJ that is cut within a face, which is read as a line.
TEST_CASE("points and lines are left out with a warning") {
  const TemporaryFolder folder;
  const auto file = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2");
  const auto mesh = load_mesh(file, {1, 1, 1}, Normals::face);
  REQUIRE(mesh.ok());
  CHECK(mesh->triangles.size() == 1);
  REQUIRE(mesh->warnings.size() == 1);
  CHECK(mesh->warnings[0].find("a.obj: ignored 1 face with fewer than three corners") !=
        std::string::npos);
}

// Protects against a texture that somebody painted and that changes no echo, without a word.
TEST_CASE("a texture is ignored with one warning a file") {
  const TemporaryFolder folder;
  const std::string faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n";
  folder.write("a.mtl",
               "newmtl plain\nKd 1 0 0\nnewmtl wood\nmap_Kd wood.png\nmap_Bump grain.png\n");
  const auto warnings = [&](const std::string& name, const std::string& text) {
    const auto mesh =
        load_mesh(folder.write(name, "mtllib a.mtl\n" + faces + text), {1, 1, 1}, Normals::face);
    REQUIRE(mesh.ok());
    return mesh->warnings;
  };
  const auto painted = warnings(
      "a.obj",
      "usemtl plain\nf 1/1 2/2 3/3\nusemtl wood\nf 1/1 2/2 4/3\nusemtl wood\nf 2/1 3/2 4/3\n");
  REQUIRE(painted.size() == 1);
  CHECK(painted[0].find("a.obj: its texture is ignored") != std::string::npos);
  CHECK(painted[0].find("reflectivity: texture with an image in texture_file") !=
        std::string::npos);
  // Whoever names an image has taken the advice.
  CHECK(load_mesh(folder.path() / "a.obj", {1, 1, 1}, Normals::face, MeshReflectivity::texture)
            ->warnings.empty());
  CHECK(warnings("b.obj", "usemtl plain\nf 1/1 2/2 3/3\n").empty());
}

// Protects the way out of warnings: once a file, behind the key that names it.
TEST_CASE("the world collects the warnings of its meshes") {
  const TemporaryFolder folder;
  const auto file = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 3\n");
  const MeshSpec mesh{file, {1, 1, 1}, false, false};
  const World world = built(scenario_of_shapes({PlaneSpec{}, mesh, mesh}));
  REQUIRE(world.warnings.size() == 1);
  CHECK(world.warnings[0].starts_with("objects.1.shape.mesh.file: "));
  CHECK(world.warnings[0].find("a.obj: ignored 1 of 2 faces") != std::string::npos);
}

// Protects materials by part: every triangle knows the part that it came from, also behind one that
// was left out.
TEST_CASE("triangles know the part of the file that they belong to") {
  const TemporaryFolder folder;
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  const auto file =
      folder.write("a.obj", corners + "o hull\nf 1 2 3\nf 1 1 2\nf 1 2 4\no mast\nf 1 3 4\n");
  const auto mesh = load_mesh(file, {1, 1, 1}, Normals::face);
  REQUIRE(mesh.ok());
  REQUIRE(mesh->triangles.size() == 3);
  REQUIRE(mesh->part.size() == 3);
  CHECK(mesh->part_names == std::vector<std::string>{"hull", "mast"});
  CHECK(mesh->part == std::vector<std::uint8_t>{0, 0, 1});
  for (std::size_t t = 0; t < 3; ++t) {
    const auto& third = mesh->vertices[mesh->triangles[t][2]];
    CHECK(third[t == 0 ? 1 : 2] == 1);
  }
}
