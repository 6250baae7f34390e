// Mesh files as people have them: marks, blanks, capitals, bytes behind the end, map coordinates.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "catch.h"
#include "is_refused.h"
#include "temporary_folder.h"
#include "world/import/import.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

const std::string kMark = "\xef\xbb\xbf";
const std::string kTriangleObj = "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n";
const std::string kTwoFacets =
    "solid Hull\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1.5e0 0 0\nvertex 0 2 "
    "0\nendloop\nendfacet\n"
    "facet normal 0 0 1\nouter loop\nvertex 0 0 1\nvertex 1.5e0 0 1\nvertex 0 2 "
    "1\nendloop\nendfacet\nendsolid Hull\n";

Result<Mesh> read(const TemporaryFolder& folder, const std::string& name, const std::string& bytes,
                  double scale = 1) {
  return import_mesh(folder.write(name, bytes), {scale, scale, scale}, Normals::face,
                     MeshReflectivity::material);
}

// Two triangles at different heights, with a head that begins like a text.
std::string two_facet_stl() {
  std::string bytes = "solid of CAD";
  bytes.resize(80, ' ');
  bytes += std::string("\2\0\0\0", 4);
  for (const float z : {0.0f, 1.0f}) {
    const float numbers[12] = {0, 0, 1, 0, 0, z, 1.5f, 0, z, 0, 2, z};
    bytes.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
    bytes.append(2, '\0');
  }
  return bytes;
}

double area_of_mesh(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 p = to_vec3(mesh.vertices[a]);
    sum += 0.5 * length(cross(to_vec3(mesh.vertices[b]) - p, to_vec3(mesh.vertices[c]) - p));
  }
  return sum;
}

std::string capitals(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string with_line_ends(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '\n' ? "\r\n" : std::string(1, c);
  return result;
}

// A square of 10 m around a place.
std::string square_at(double x, double y, double z, double half = 5) {
  std::string text;
  for (const auto& [u, v] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    text += "v " + std::to_string(x + half * u) + ' ' + std::to_string(y + half * v) + ' ' +
            std::to_string(z) + '\n';
  }
  return text + "f 1 2 3 4\n";
}

}  // namespace

TEST_CASE("bytes behind the last face of a binary STL are ignored with a warning") {
  const TemporaryFolder folder;
  CHECK(read(folder, "a.stl", two_facet_stl())->warnings.empty());
  for (const std::size_t more : {1, 10, 50, 4096}) {
    INFO(more << " bytes");
    const auto mesh = read(folder, "b.stl", two_facet_stl() + std::string(more, 'x'));
    REQUIRE(mesh.ok());
    CHECK(mesh->triangles.size() == 2);
    CHECK(area_of_mesh(*mesh) == Approx(3));
    REQUIRE(mesh->warnings.size() == 1);
    CHECK(mesh->warnings[0].find("b.stl: ignored " + std::to_string(more) + " byte") !=
          std::string::npos);
    CHECK(mesh->warnings[0].find("behind the last of the 2 faces that its head announces") !=
          std::string::npos);
  }
}

TEST_CASE("ASCII STL may have capitals, blank lines first and a byte order mark") {
  const TemporaryFolder folder;
  const std::string mixed =
      "Solid Hull\nFacet Normal 0 0 1\nOuter Loop" + kTwoFacets.substr(kTwoFacets.find("\nvertex"));
  for (const std::string& text :
       {kTwoFacets, capitals(kTwoFacets), mixed, "\n\n  \t\r\n" + kTwoFacets, kMark + kTwoFacets,
        kMark + "\n" + capitals(kTwoFacets), with_line_ends(kTwoFacets),
        "\r\n" + with_line_ends(capitals(kTwoFacets))}) {
    INFO(text);
    const auto mesh = read(folder, "a.stl", text);
    REQUIRE(mesh.ok());
    CHECK(mesh->triangles.size() == 2);
    CHECK(area_of_mesh(*mesh) == Approx(3));
    CHECK(mesh->warnings.empty());
    REQUIRE(mesh->part_names.size() == 1);
    CHECK(capitals(mesh->part_names[0]) == "HULL");
  }
  CHECK(read(folder, "a.stl", "\n" + kTwoFacets)->part_names[0] == "Hull");
  // A name may be a keyword.
  std::string named = kTwoFacets;
  named.replace(named.rfind("Hull"), 4, "facet_model");
  CHECK(read(folder, "named.stl", named)->triangles.size() == 2);
  // A file that is cut off is none of these.
  std::string head = two_facet_stl();
  head.replace(0, 5, "parts");
  CHECK(is_refused(read(folder, "cut.stl", head.substr(0, head.size() - 10)),
                   "its head announces 2 faces, and it ends before the last"));
  const std::string large = capitals(kTwoFacets);
  CHECK(is_refused(read(folder, "cut.stl", large.substr(0, large.find("ENDSOLID"))),
                   "ends without endsolid"));
}

TEST_CASE("a facet of an STL without three corners is refused with its number") {
  const TemporaryFolder folder;
  std::string four = kTwoFacets, two = kTwoFacets;
  four.insert(four.rfind("endloop"), "vertex 1 1 1\n");
  two.erase(two.find("vertex"), two.find("vertex 1.5") - two.find("vertex"));
  CHECK(is_refused(read(folder, "four.stl", four), "four.stl: facet 1 has 4 corners; expected 3",
                   ErrorKind::usage));
  CHECK(is_refused(read(folder, "two.stl", two), "two.stl: facet 0 has 2 corners; expected 3"));
}

TEST_CASE("a byte order mark is no part of a text") {
  const TemporaryFolder folder;
  const std::string ply_text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 2 0\n3 "
      "0 1 2\n";
  const std::string dae_text = R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 2 0</float_array>
<technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
  const std::string gltf_text =
      R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
"buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAEAAAAAA"}]})";
  for (const auto& [name, text] : {std::pair<std::string, std::string>{"a.obj", kTriangleObj},
                                   {"a.ply", ply_text},
                                   {"a.dae", dae_text},
                                   {"a.gltf", gltf_text}}) {
    for (const std::string& mark : {std::string(), kMark}) {
      INFO(name << (mark.empty() ? "" : " with a mark"));
      const auto mesh = read(folder, name, mark + text);
      INFO((mesh.ok() ? "" : mesh.error().message));
      REQUIRE(mesh.ok());
      CHECK(area_of_mesh(*mesh) == Approx(1));
      CHECK(mesh->warnings.empty());
    }
  }
  // The material file of an OBJ is still found next to it.
  folder.write("a.mtl", "newmtl wood\nmap_Kd wood.png\n");
  const auto painted = read(folder, "b.obj", kMark + "mtllib a.mtl\nusemtl wood\n" + kTriangleObj);
  REQUIRE(painted.ok());
  CHECK(painted->part_names == std::vector<std::string>{"wood"});
  REQUIRE(painted->warnings.size() == 1);
  CHECK(painted->warnings[0].find("its texture is ignored") != std::string::npos);
}

TEST_CASE("UTF-16 is refused with the way out") {
  const TemporaryFolder folder;
  for (const char* name : {"a.obj", "a.ply", "a.stl", "a.gltf"}) {
    std::string text = "\xff\xfe";
    for (const char c : kTriangleObj) text += std::string(1, c) + '\0';
    CHECK(is_refused(read(folder, name, text),
                     std::string(name) + ": is text in UTF-16; save it as UTF-8"));
  }
}

// Protects survey meshes: what single precision would make of them looks like a rough seabed.
TEST_CASE("map coordinates are refused with the origin to subtract") {
  const TemporaryFolder folder;
  CHECK(is_refused(read(folder, "utm.obj", square_at(448'123.25, 5'734'210.5, -20)),
                   "utm.obj: lies around (448100, 5734200, 0) m, where single precision rounds its "
                   "coordinates to 0.5 m; "
                   "subtract this origin",
                   ErrorKind::usage));
  CHECK(is_refused(read(folder, "east.obj", square_at(448'123.25, 0, 0)),
                   "(448100, 0, 0) m, where single precision rounds its coordinates to 0.031 m"));
  CHECK(is_refused(read(folder, "m.obj", square_at(448'123'250, 0, 0, 5000), 1e-3),
                   "(448100, 0, 0) m"));
  // Steps below a centimeter, and large bodies around their origin.
  CHECK(read(folder, "near.obj", square_at(40'000, -30'000, 0)).ok());
  CHECK(read(folder, "large.obj", square_at(150'000, 0, 0, 100'000)).ok());
  CHECK(read(folder, "mm.obj", square_at(448'123, 5000, 0, 5000), 1e-3).ok());
}
