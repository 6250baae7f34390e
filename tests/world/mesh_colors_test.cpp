// Colors of vertices for a camera, from files that are written here byte by byte.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "catch.h"
#include "formats/bytes.h"
#include "is_refused.h"
#include "temporary_folder.h"
#include "world/curved_mesh.h"
#include "world/import/import.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

using Triple = std::array<float, 3>;

// In 255ths; the first mixes channels.
constexpr std::array<std::array<int, 3>, 3> kColors = {{{255, 51, 102}, {0, 255, 0}, {5, 0, 255}}};
constexpr std::array<Triple, 3> kPlaces = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};

template <class T>
void append(std::string& bytes, T value, bool big_endian = false) {
  std::array<char, sizeof(T)> raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (big_endian) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

std::string ply_head(const std::string& format, const std::string& type) {
  return fmt::format(
      "ply\nformat {0} 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nproperty {1} red\nproperty {1} green\nproperty {1} blue\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n",
      format, type);
}

std::string text_ply(bool whole) {
  std::string text = ply_head("ascii", whole ? "uchar" : "float");
  for (int v = 0; v < 3; ++v) {
    text += fmt::format("{} {} {}", kPlaces[v][0], kPlaces[v][1], kPlaces[v][2]);
    for (const int c : kColors[v])
      text += whole ? fmt::format(" {}", c) : fmt::format(" {}", c / 255.0);
    text += "\n";
  }
  return text + "3 0 1 2\n";
}

std::string binary_ply(bool whole, bool big) {
  std::string bytes =
      ply_head(big ? "binary_big_endian" : "binary_little_endian", whole ? "uchar" : "float");
  for (int v = 0; v < 3; ++v) {
    for (const float x : kPlaces[v]) append(bytes, x, big);
    for (const int c : kColors[v]) {
      if (whole) append(bytes, static_cast<std::uint8_t>(c));
      if (!whole) append(bytes, static_cast<float>(c) / 255, big);
    }
  }
  append(bytes, std::uint8_t{3});
  for (const std::int32_t v : {0, 1, 2}) append(bytes, v, big);
  return bytes;
}

std::string obj(const std::string& second = "0 1 0") {
  return "v 0 0 0 1 0.2 0.4\nv 1 0 0 " + second + "\nv 0 1 0 0.0196078 0 1\nf 1 2 3\n";
}

// Two primitives, of which only the first has colors, of `parts` numbers: floats (5126), or whole
// numbers with 8 (5121) or 16 bits (5123).
std::string gltf(int component, int parts) {
  std::string bytes;
  for (const Triple& place : kPlaces) {
    for (const float x : place) append(bytes, x);
  }
  for (const auto& color : kColors) {
    for (int c = 0; c < parts; ++c) {
      const int share = c < 3 ? color[c] : 255;
      if (component == 5121) append(bytes, static_cast<std::uint8_t>(share));
      if (component == 5123) append(bytes, static_cast<std::uint16_t>(share * 257));
      if (component == 5126) append(bytes, static_cast<float>(share) / 255);
    }
    bytes.resize((bytes.size() + 3) / 4 * 4);
  }
  const std::size_t stride = (bytes.size() - 36) / 3;
  return fmt::format(
      R"({{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "COLOR_0": 1}}}}, {{"attributes": {{"POSITION": 0}}}}]}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}},
{{"bufferView": 1, "componentType": {}, "normalized": {}, "count": 3, "type": "VEC{}"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 36}}, {{"buffer": 0, "byteOffset": 36, "byteLength": {}, "byteStride": {}}}],
"buffers": [{{"byteLength": {}, "uri": "data:application/octet-stream;base64,{}"}}]}})",
      component, component != 5126, parts, 3 * stride, stride, bytes.size(), base64(bytes));
}

Result<Mesh> read(const std::filesystem::path& file, Normals normals = Normals::face,
                  MeshReflectivity reflectivity = MeshReflectivity::material) {
  return import_mesh(file, {1, 1, 1}, normals, reflectivity, true);
}

double light_of(int code) {  // IEC 61966-2-1
  return code <= 10 ? code / 255.0 / 12.92 : std::pow((code / 255.0 + 0.055) / 1.055, 2.4);
}

void check_colors(const Mesh& mesh, bool is_linear) {
  REQUIRE(mesh.colors.size() == mesh.vertices.size());
  REQUIRE(mesh.vertices.size() >= 3);
  for (std::size_t v = 0; v < 3; ++v) {
    const Triple& place = mesh.vertices[v];
    // glTF has y up.
    const std::size_t k = place[0] == 1 ? 1 : place[1] == 1 || place[2] == 1 ? 2 : 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double expected = is_linear ? kColors[k][c] / 255.0 : light_of(kColors[k][c]);
      CHECK(mesh.colors[v][c] == Approx(expected).margin(1e-6));
    }
  }
}

}  // namespace

// Protects colors of each format: sRGB of PLY and OBJ, linear ones of glTF.
TEST_CASE("vertex colors of each format") {
  const TemporaryFolder folder;
  int number = 0;
  const auto check = [&](const std::string& bytes, const std::string& ending) {
    const auto file = folder.write(fmt::format("{}{}", number++, ending), bytes);
    INFO(file.string());
    const auto mesh = read(file);
    REQUIRE(mesh.ok());
    check_colors(*mesh, ending == ".gltf");
    CHECK(import_mesh(file, {1, 1, 1}, Normals::face, MeshReflectivity::material)->colors.empty());
    if (ending != ".gltf") return;
    REQUIRE(mesh->vertices.size() == 6);
    for (std::size_t v = 3; v < 6; ++v) CHECK(std::isnan(mesh->colors[v][0]));
  };
  for (const bool whole : {true, false}) {
    check(text_ply(whole), ".ply");
    for (const bool big : {true, false}) check(binary_ply(whole, big), ".ply");
  }
  check(obj(), ".obj");
  for (const int component : {5121, 5123, 5126}) {
    for (const int parts : {3, 4}) check(gltf(component, parts), ".gltf");
  }
}

// Protects sharp borders of paint on smooth bodies, and meshes whose colors also scale echoes.
TEST_CASE("vertex colors beside smooth normals and reflectivity") {
  const TemporaryFolder folder;
  const auto file = folder.write("a.obj",
                                 "v 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\n"
                                 "v 1 0 0 0 0 0\nv 0 1 0 0 0 0\nv 1 1 1 0 0 0\n"
                                 "f 1 2 3\nf 4 6 5\n");
  const auto mesh = read(file, Normals::smooth, MeshReflectivity::vertex_color);
  REQUIRE(mesh.ok());
  REQUIRE(mesh->triangles.size() == 2);
  for (const auto& triangle : mesh->triangles) {
    const float first = mesh->colors[triangle[0]][0];
    for (const std::uint32_t v : triangle) {
      CHECK(mesh->colors[v] == Triple{first, first, first});
      CHECK(mesh->reflectivity[v] == first);
    }
  }
  // Without colors to read, vertices are joined as ever.
  const auto plain =
      folder.write("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nf 1 2 3\nf 2 4 3\n");
  CHECK(read(plain, Normals::smooth)->vertices.size() == 4);
  CHECK(read(plain, Normals::smooth)->colors.empty());
}

// Protects bodies that are cut for their echoes: a new vertex has the color of its place.
TEST_CASE("a smooth body keeps its vertex colors") {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals = {{-0.1F, 0, 0.995F}, {0.1F, 0, 0.995F}, {0, 0.1F, 0.995F}};
  mesh.triangles = {{0, 1, 2}};
  mesh.colors = {{0, 0, 0.5F}, {1, 0, 0.5F}, {0, 1, 0.5F}};
  const auto curved = curved_mesh(mesh, 0.001);
  REQUIRE(curved.ok());
  REQUIRE(curved->vertices.size() > 3);
  REQUIRE(curved->colors.size() == curved->vertices.size());
  for (std::size_t v = 0; v < curved->vertices.size(); ++v) {
    REQUIRE(curved->colors[v][0] == Approx(curved->vertices[v][0]).margin(0.05));
    REQUIRE(curved->colors[v][1] == Approx(curved->vertices[v][1]).margin(0.05));
    REQUIRE(curved->colors[v][2] == 0.5F);
  }
}

// Protects users from colors that would land on other vertices, or that mean something else.
TEST_CASE("wrong vertex colors are refused") {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& second, const std::string& why) {
    const auto mesh = read(folder.write("a.obj", obj(second)));
    CHECK(is_refused(mesh, "a.obj", ErrorKind::usage));
    CHECK(is_refused(mesh, why));
  };
  refuse("", "line 2: the vertex has no color, but that of line 1 has one");
  refuse("# 0 1 0", "line 2: the vertex has no color");
  refuse("0 .5 0", "line 2: a number begins with a point");
  refuse("0 255 0", "has the color 0 255 0; expected red, green and blue from 0 to 1");
  refuse("0 -0.5 0", "has the color 0 -0.5 0");
}
