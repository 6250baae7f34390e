#include "world/mesh.h"

#include <algorithm>
#include <cmath>

#include "catch.h"
#include "is_refused.h"
#include "temporary_folder.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

const char* kWedgeObj =
    "v 0 0 0\nv 2 0 0\nv 0 3 0\nv 0 0 4\n"
    "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

// A COLLADA triangle whose third vertex is at (0, 0, 5) of the file, in its unit and up axis.
std::string dae(const std::string& up, const std::string& metres) {
  return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="u" meter=")" +
         metres + R"("/><up_axis>)" + up + R"(</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 1 2 0 0 0 5</float_array>
<technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

bool has_vertex(const Mesh& mesh, double x, double y, double z) {
  for (const auto& v : mesh.vertices) {
    if (std::abs(v[0] - x) + std::abs(v[1] - y) + std::abs(v[2] - z) < 1e-6) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("OBJ and STL are taken as they are, times the scale") {
  const TemporaryFolder folder;
  const auto obj = load_mesh(folder.write("wedge.obj", kWedgeObj), {0.5, 0.5, 0.5}, Normals::face);
  REQUIRE(obj.ok());
  CHECK(obj->triangles.size() == 4);
  CHECK(has_vertex(*obj, 1, 0, 0));
  CHECK(has_vertex(*obj, 0, 1.5, 0));
  CHECK(has_vertex(*obj, 0, 0, 2));
  const auto stl =
      load_mesh(folder.write("one.stl",
                             "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                             "vertex 0 7 0\nendloop\nendfacet\nendsolid x\n"),
                {1, 1, 1}, Normals::face);
  REQUIRE(stl.ok());
  CHECK(has_vertex(*stl, 0, 7, 0));
}

// Protects users of COLLADA: z up and metres, whichever axis and unit the file speaks of.
TEST_CASE("DAE comes out z up and in metres") {
  const TemporaryFolder folder;
  const auto z_up = load_mesh(folder.write("z.dae", dae("Z_UP", "1")), {1, 1, 1}, Normals::face);
  REQUIRE(z_up.ok());
  CHECK(has_vertex(*z_up, 0, 0, 5));
  CHECK(has_vertex(*z_up, 1, 2, 0));
  const auto y_up = load_mesh(folder.write("y.dae", dae("Y_UP", "1")), {1, 1, 1}, Normals::face);
  REQUIRE(y_up.ok());
  CHECK(has_vertex(*y_up, 1, 0, 2));   // its y is up
  CHECK(has_vertex(*y_up, 0, -5, 0));  // its z points to the viewer
  const auto inches = load_mesh(folder.write("i.dae", dae("Z_UP", "0.0254")), {1, 1, 1}, Normals::face);
  REQUIRE(inches.ok());
  CHECK(has_vertex(*inches, 0, 0, 0.127));
}

// An independent route: the same mesh, stretched in its file. A plane a x + b y + c z = d that is
// stretched by s along x is a/s x + b y + c z = d, whose normal is that of the inverse transpose.
TEST_CASE("a scale for each axis is that of a stretched file") {
  const TemporaryFolder folder;
  const std::string normals = "vn 0.6 0 0.8\nvn 0.6 0.8 0\nvn 0 0 1\nf 1//1 2//2 3//3\n";
  const auto plain = folder.write("a.obj", "v 1 2 3\nv 4 2.5 1\nv 0 1 -2\n" + normals);
  const auto stretched = folder.write("b.obj", "v 2 2 0.75\nv 8 2.5 0.25\nv 0 1 -0.5\n" + normals);
  const auto face = load_mesh(plain, {2, 1, 0.25}, Normals::face);
  const auto same = load_mesh(stretched, {1, 1, 1}, Normals::face);
  REQUIRE(face.ok());
  REQUIRE(same.ok());
  CHECK(face->vertices == same->vertices);
  CHECK(face->triangles == same->triangles);
  const auto smooth = load_mesh(plain, {2, 1, 0.25}, Normals::smooth);
  REQUIRE(smooth.ok());
  const Vec3 wanted[] = {normalized(Vec3{0.3, 0, 3.2}), normalized(Vec3{0.3, 0.8, 0}), Vec3{0, 0, 1}};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(length(to_vec3(smooth->normals[i]) - wanted[i]) < 1e-6);
  }
}

// Protects smooth bodies: shared vertices of a wedge get normals between those of their faces.
TEST_CASE("smooth normals are of unit length and between faces") {
  const TemporaryFolder folder;
  const auto mesh = load_mesh(folder.write("wedge.obj", kWedgeObj), {1, 1, 1}, Normals::smooth);
  REQUIRE(mesh.ok());
  REQUIRE(mesh->normals.size() == mesh->vertices.size());
  for (const auto& n : mesh->normals) CHECK(std::hypot(n[0], n[1], n[2]) == Approx(1).margin(1e-5));
  CHECK(load_mesh(folder.path() / "wedge.obj", {1, 1, 1}, Normals::face)->normals.empty());
}

TEST_CASE("what is no mesh is refused with its name") {
  const TemporaryFolder folder;
  for (const auto& [name, text] : {std::pair<std::string, std::string>{"empty.obj", ""},
                                   {"words.stl", "this is not a mesh"},
                                   {"points.obj", "v 0 0 0\nv 1 0 0\n"},
                                   {"nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
                                   {"cut.dae", dae("Z_UP", "1").substr(0, 400)}}) {
    INFO(name);
    const auto mesh = load_mesh(folder.write(name, text), {1, 1, 1}, Normals::face);
    CHECK(is_refused(mesh, name, ErrorKind::usage));
  }
}

// Protects the process: parts of lines beside parts of faces, and faces that name vertices that are
// not there, which a smooth normal or a hit would read.
TEST_CASE("lines are passed over, faces without their vertices refused") {
  const TemporaryFolder folder;
  const auto lines = folder.write(
      "lines.obj", "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no b\nv 5 5 5\nv 6 6 6\nl 4 5\n");
  const auto beyond = folder.write(
      "beyond.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 90000000\n");
  for (const Normals normals : {Normals::face, Normals::smooth}) {
    const auto mesh = load_mesh(lines, {1, 1, 1}, normals);
    REQUIRE(mesh.ok());
    CHECK(mesh->triangles.size() == 1);
    CHECK_FALSE(has_vertex(*mesh, 5, 5, 5));
    const auto refused = load_mesh(beyond, {1, 1, 1}, normals);
    CHECK(is_refused(refused, "beyond.ply"));
  }
}

// Protects data sets that are run again: all of a mesh must be in the one file that is kept.
TEST_CASE("glTF with its buffers elsewhere is refused") {
  const TemporaryFolder folder;
  const auto file = folder.write(
      "a.gltf",
      R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 36, "uri": "b.bin"}]})");
  const auto mesh = load_mesh(file, {1, 1, 1}, Normals::face);
  CHECK(is_refused(mesh, "b.bin"));
  CHECK(is_refused(mesh, ".glb"));
}

namespace {

// A triangle whose corners have the colours given, as "r g b".
std::string ply(const std::string& type, const std::string& a, const std::string& b,
                const std::string& c) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex 3\n";
  for (const char* name : {"x", "y", "z"}) text += std::string("property float ") + name + "\n";
  for (const char* name : {"red", "green", "blue"}) text += "property " + type + " " + name + "\n";
  return text +
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0 " +
         a + "\n1 0 0 " + b + "\n0 1 0 " + c + "\n3 0 1 2\n";
}

// The reflectivity of the vertices at a place.
std::vector<float> reflectivity_at(const Mesh& mesh, float x, float y, float z) {
  std::vector<float> found;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (mesh.vertices[v] == std::array<float, 3>{x, y, z}) found.push_back(mesh.reflectivity[v]);
  }
  return found;
}

}  // namespace

// Protects painted meshes: the mean of red, green and blue, at the vertex it belongs to.
TEST_CASE("vertex colours become reflectivity") {
  const TemporaryFolder folder;
  const auto file = folder.write("a.ply", ply("uchar", "255 0 0", "255 255 255", "0 51 102"));
  for (const Normals normals : {Normals::face, Normals::smooth}) {
    const auto mesh = load_mesh(file, {1, 1, 1}, normals, MeshReflectivity::vertex_color);
    REQUIRE(mesh.ok());
    REQUIRE(mesh->reflectivity.size() == mesh->vertices.size());
    CHECK(reflectivity_at(*mesh, 0, 0, 0).at(0) == Approx(1 / 3.0));
    CHECK(reflectivity_at(*mesh, 1, 0, 0).at(0) == Approx(1));
    CHECK(reflectivity_at(*mesh, 0, 1, 0).at(0) == Approx(0.2));
    CHECK(load_mesh(file, {1, 1, 1}, normals)->reflectivity.empty());
  }
}

// Protects sharp borders of paint on smooth bodies: vertices of one place but two colours stay two,
// with one normal.
TEST_CASE("differently coloured vertices are not joined") {
  const TemporaryFolder folder;
  const auto file = folder.write("a.obj",
                                 "v 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\n"
                                 "v 1 0 0 0 0 0\nv 0 1 0 0 0 0\nv 1 1 1 0 0 0\n"
                                 "f 1 2 3\nf 4 6 5\n");
  const auto mesh = load_mesh(file, {1, 1, 1}, Normals::smooth, MeshReflectivity::vertex_color);
  REQUIRE(mesh.ok());
  REQUIRE(mesh->triangles.size() == 2);
  auto shared = reflectivity_at(*mesh, 1, 0, 0);
  std::sort(shared.begin(), shared.end());
  CHECK(shared == std::vector<float>{0, 1});
  std::vector<std::array<float, 3>> normals;
  for (std::size_t v = 0; v < mesh->vertices.size(); ++v) {
    if (mesh->vertices[v] == std::array<float, 3>{1, 0, 0}) normals.push_back(mesh->normals[v]);
  }
  REQUIRE(normals.size() == 2);
  CHECK(normals[0] == normals[1]);
  CHECK(std::abs(normals[0][2]) < 0.999);  // that of no face of the two
  for (const auto& triangle : mesh->triangles) {
    CHECK(mesh->reflectivity[triangle[0]] == mesh->reflectivity[triangle[1]]);
    CHECK(mesh->reflectivity[triangle[0]] == mesh->reflectivity[triangle[2]]);
  }
  // Without colours they are the same vertex.
  CHECK(load_mesh(file, {1, 1, 1}, Normals::smooth)->vertices.size() == 4);
}

TEST_CASE("colours that are missing or no reflectivity are refused") {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& name, const std::string& text,
                          const std::string& why) {
    INFO(name);
    const auto mesh =
        load_mesh(folder.write(name, text), {1, 1, 1}, Normals::face, MeshReflectivity::vertex_color);
    CHECK(is_refused(mesh, name, ErrorKind::usage));
    CHECK(is_refused(mesh, why));
  };
  refuse("plain.obj", kWedgeObj, "has no vertex colors");
  refuse("plain.dae", dae("Z_UP", "1"), "has no vertex colors");
  refuse("bright.ply", ply("float", "0 0 0", "1 1.5 1", "0 0 0"), "has the color 1 1.5 1");
  refuse("negative.ply", ply("float", "0 0 0", "0 0 -0.1", "0 0 0"), "has the color 0 0 -0.1");
  refuse("nan.ply", ply("float", "0 0 0", "0 nan 0", "0 0 0"), "has the color 0 nan 0");
}
