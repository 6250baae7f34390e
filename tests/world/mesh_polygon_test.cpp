// Faces of many corners through the reader of each format.
#include <cmath>
#include <cstring>
#include <sstream>

#include "catch.h"
#include "temporary_folder.h"
#include "world/import/import.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

using Corner = std::array<float, 3>;

// The end of a beam of H section, and one that crosses itself.
const std::vector<Corner> kSection = {{1, -15, -15}, {1, 15, -15}, {1, 15, -12}, {1, 2, -12},
                                      {1, 2, 12},    {1, 15, 12},  {1, 15, 15},  {1, -15, 15},
                                      {1, -15, 12},  {1, -2, 12},  {1, -2, -12}, {1, -15, -12}};
constexpr double kSectionArea = 2 * 30 * 3 + 24 * 4;
const std::vector<Corner> kBowTie = {{0, 0, 0}, {8, 0, 0}, {2, 4, 0}, {6, 4, 0}};

std::string rows_of(const std::vector<Corner>& corners) {
  std::ostringstream text;
  for (const auto& [x, y, z] : corners) text << x << ' ' << y << ' ' << z << '\n';
  return text.str();
}

// The numbers from `first` on, for each corner of a face.
std::string indices_of(const std::vector<Corner>& corners, int first) {
  std::string text;
  for (std::size_t i = 0; i < corners.size(); ++i)
    text += ' ' + std::to_string(first + static_cast<int>(i));
  return text;
}

std::string obj_of(const std::vector<Corner>& corners) {
  std::string text;
  std::istringstream rows(rows_of(corners));
  for (std::string row; std::getline(rows, row);) text += "v " + row + '\n';
  return text + 'f' + indices_of(corners, 1) + '\n';
}

std::string ply_head(const std::vector<Corner>& corners, const std::string& format) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(corners.size()) +
         "\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string ascii_ply_of(const std::vector<Corner>& corners) {
  return ply_head(corners, "ascii") + rows_of(corners) + std::to_string(corners.size()) +
         indices_of(corners, 0) + '\n';
}

std::string binary_ply_of(const std::vector<Corner>& corners, bool big_endian) {
  std::string bytes = ply_head(corners, big_endian ? "binary_big_endian" : "binary_little_endian");
  const auto put = [&](auto value) {
    std::string raw(sizeof value, '\0');
    std::memcpy(raw.data(), &value, sizeof value);
    bytes += big_endian ? std::string(raw.rbegin(), raw.rend()) : raw;
  };
  for (const Corner& corner : corners) {
    for (const float x : corner) put(x);
  }
  bytes += static_cast<char>(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) put(static_cast<std::int32_t>(i));
  return bytes;
}

std::string dae_of(const std::vector<Corner>& corners, const std::string& faces) {
  const std::string count = std::to_string(corners.size());
  return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="m" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count=")" +
         std::to_string(3 * corners.size()) + "\">" + rows_of(corners) +
         R"(</float_array><technique_common><accessor source="#a" count=")" + count +
         R"(" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>)" +
         faces + R"(</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

const std::string kDaeInput = R"(<input semantic="VERTEX" source="#v" offset="0"/>)";

std::string dae_polylist_of(const std::vector<Corner>& corners) {
  return dae_of(corners, "<polylist count=\"1\">" + kDaeInput + "<vcount>" +
                             std::to_string(corners.size()) + "</vcount><p>" +
                             indices_of(corners, 0) + "</p></polylist>");
}

std::string dae_polygons_of(const std::vector<Corner>& corners) {
  return dae_of(corners, "<polygons count=\"1\">" + kDaeInput + "<p>" + indices_of(corners, 0) +
                             "</p></polygons>");
}

// A name with the format's ending, and the file.
std::vector<std::pair<std::string, std::string>> files_of(const std::vector<Corner>& corners) {
  return {{"a.obj", obj_of(corners)},
          {"a.ply", ascii_ply_of(corners)},
          {"little.ply", binary_ply_of(corners, false)},
          {"big.ply", binary_ply_of(corners, true)},
          {"polylist.dae", dae_polylist_of(corners)},
          {"polygons.dae", dae_polygons_of(corners)}};
}

Result<Mesh> mesh_of(const TemporaryFolder& folder, const std::string& name,
                     const std::string& bytes, Normals normals = Normals::face) {
  return import_mesh(folder.write(name, bytes), {1, 1, 1}, normals, MeshReflectivity::material);
}

double area_of(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 p = to_vec3(mesh.vertices[a]);
    sum += 0.5 * length(cross(to_vec3(mesh.vertices[b]) - p, to_vec3(mesh.vertices[c]) - p));
  }
  return sum;
}

}  // namespace

TEST_CASE("a face of many corners has its area from every first corner, in every format") {
  const TemporaryFolder folder;
  std::vector<Corner> corners = kSection;
  for (std::size_t first = 0; first < corners.size(); ++first) {
    std::rotate(corners.begin(), corners.begin() + 1, corners.end());
    for (const auto& [name, bytes] : files_of(corners)) {
      for (const Normals normals : {Normals::face, Normals::smooth}) {
        INFO(name << " from corner " << first);
        const auto mesh = mesh_of(folder, name, bytes, normals);
        REQUIRE(mesh.ok());
        CHECK(mesh->warnings.empty());
        CHECK(mesh->triangles.size() == corners.size() - 2);
        CHECK(area_of(*mesh) == Approx(kSectionArea).epsilon(1e-6));
        for (const auto& normal : mesh->normals) CHECK(std::abs(normal[0]) > 0.999f);
      }
    }
  }
}

// Protects against an area that nobody meant: which face it is, and what to do.
TEST_CASE("a face that crosses itself is warned of with its number, in every format") {
  const TemporaryFolder folder;
  for (const auto& [name, bytes] : files_of(kBowTie)) {
    INFO(name);
    const auto mesh = mesh_of(folder, name, bytes);
    REQUIRE(mesh.ok());
    REQUIRE(!mesh->warnings.empty());
    CHECK(mesh->warnings[0].find(name + ": a face crosses itself") != std::string::npos);
    CHECK(mesh->warnings[0].find("face 0 of part 0") != std::string::npos);
    CHECK(mesh->warnings[0].find("divide such faces into triangles before the export") !=
          std::string::npos);
  }
  const std::string square = "v 0 0 0\nv 8 0 0\nv 8 8 0\nv 0 8 0\nv 2 4 0\nv 6 4 0\n";
  const auto mesh =
      mesh_of(folder, "third.obj", square + "f 1 2 3 4\nf 1 2 3\nf 1 2 5 6\nf 1 2 5 6\n");
  REQUIRE(mesh.ok());
  REQUIRE(!mesh->warnings.empty());
  CHECK(mesh->warnings[0].find(
            "face 2 of part 0 ('defaultobject'), with a corner at (0, 0, 0) (and 1 more)") !=
        std::string::npos);
}
