// glTF whose vertices are whole numbers, and what a file requires.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

#include "catch.h"
#include "formats/bytes.h"
#include "is_refused.h"
#include "temporary_folder.h"
#include "world/import/import.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

struct Vertex {
  std::array<double, 3> position, normal;
  std::array<double, 2> uv;
};

// A tetrahedron in [-1, 1], or in [0, 1] for types without sign.
std::vector<Vertex> vertices(bool is_signed) {
  std::vector<Vertex> all = {{{-0.9, -0.8, -0.7}, {0.6, 0, 0.8}, {0.1, 0.9}},
                             {{1, -0.5, -0.6}, {0, 1, 0}, {1, 0.25}},
                             {{0.1, 0.95, -0.4}, {0, 0.6, -0.8}, {0, 0.7}},
                             {{0.2, 0.3, 0.85}, {-1, 0, 0}, {0.4, 0.3}}};
  if (is_signed) return all;
  for (Vertex& vertex : all) {
    for (double& x : vertex.position) x = 0.5 + 0.5 * x;
  }
  return all;
}

// How an attribute is stored: the numbers are value / step.
struct Storage {
  int component = 5126;
  bool normalized = false;
  double step = 1;
};

void put_number(std::string& bytes, int component, double number) {
  if (component == 5120) return put_value(bytes, static_cast<std::int8_t>(std::lround(number)));
  if (component == 5121) return put_value(bytes, static_cast<std::uint8_t>(std::lround(number)));
  if (component == 5122) return put_value(bytes, static_cast<std::int16_t>(std::lround(number)));
  if (component == 5123) return put_value(bytes, static_cast<std::uint16_t>(std::lround(number)));
  put_value(bytes, static_cast<float>(number));
}

// As gltfpack pads it: to a multiple of four bytes.
std::size_t stride_of(int component, std::size_t parts) {
  const std::size_t size = component == 5126 ? 4 : component >= 5122 ? 2 : 1;
  return (size * parts + 3) / 4 * 4;
}

struct File {
  Storage position, normal, uv;
  std::string node, material, extensions;  // JSON to put in
};

std::string accessor(std::size_t view, const Storage& storage, const std::string& type) {
  return R"({"bufferView": )" + std::to_string(view) + R"(, "componentType": )" +
         std::to_string(storage.component) + (storage.normalized ? R"(, "normalized": true)" : "") +
         R"(, "count": 4, "type": ")" + type + R"("})";
}

// The bytes of the buffer and the file's JSON, with `uri` for the buffer.
std::pair<std::string, std::function<std::string(const std::string&)>> gltf_parts(
    const File& file, const std::vector<Vertex>& all) {
  std::string bytes, views;
  const auto add = [&](const Storage& storage, std::size_t parts, auto number) {
    const std::size_t stride = stride_of(storage.component, parts), begin = bytes.size();
    for (const Vertex& vertex : all) {
      const std::size_t end = bytes.size() + stride;
      for (std::size_t i = 0; i < parts; ++i)
        put_number(bytes, storage.component, number(vertex, i) / storage.step);
      bytes.resize(end);
    }
    views += R"({"buffer": 0, "byteOffset": )" + std::to_string(begin) + R"(, "byteLength": )" +
             std::to_string(bytes.size() - begin) + R"(, "byteStride": )" + std::to_string(stride) +
             "}, ";
  };
  add(file.position, 3, [](const Vertex& v, std::size_t i) { return v.position[i]; });
  add(file.normal, 3, [](const Vertex& v, std::size_t i) { return v.normal[i]; });
  add(file.uv, 2, [](const Vertex& v, std::size_t i) { return v.uv[i]; });
  const std::size_t begin = bytes.size();
  for (const int i : {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3})
    put_value(bytes, static_cast<std::uint16_t>(i));
  views += R"({"buffer": 0, "byteOffset": )" + std::to_string(begin) + R"(, "byteLength": 24})";
  const std::size_t length = bytes.size();
  return {
      bytes, [=](const std::string& uri) {
        return R"({"asset": {"version": "2.0"}, )" + file.extensions +
               R"("scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0)" + file.node +
               R"(}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]}], )" +
               R"("textures": [{"source": 0}], "images": [{"uri": "a.png"}], "materials": [{"pbrMetallicRoughness": {)" +
               file.material + R"(}}], "accessors": [)" + accessor(0, file.position, "VEC3") +
               ", " + accessor(1, file.normal, "VEC3") + ", " + accessor(2, file.uv, "VEC2") +
               R"(, {"bufferView": 3, "componentType": 5123, "count": 12, "type": "SCALAR"}], "bufferViews": [)" +
               views + R"(], "buffers": [{)" + uri + R"("byteLength": )" + std::to_string(length) +
               "}]}";
      }};
}

std::string glb_of(std::string json, std::string binary) {
  json.append((4 - json.size() % 4) % 4, ' ');
  binary.append((4 - binary.size() % 4) % 4, '\0');
  std::string bytes = "glTF";
  const auto number = [&](std::size_t value) {
    put_value(bytes, static_cast<std::uint32_t>(value));
  };
  number(2);
  number(12 + 8 + json.size() + 8 + binary.size());
  number(json.size());
  bytes += "JSON" + json;
  number(binary.size());
  return bytes + std::string("BIN\0", 4) + binary;
}

std::string glb_of(const File& file, const std::vector<Vertex>& all = vertices(true)) {
  const auto [bytes, json] = gltf_parts(file, all);
  return glb_of(json(""), bytes);
}

std::string gltf_of(const File& file, const std::vector<Vertex>& all) {
  const auto [bytes, json] = gltf_parts(file, all);
  return json(R"("uri": "data:application/octet-stream;base64,)" + base64(bytes) + R"(", )");
}

Result<Mesh> gltf_mesh(const TemporaryFolder& folder, const std::string& name,
                       const std::string& bytes,
                       MeshReflectivity reflectivity = MeshReflectivity::texture) {
  return import_mesh(folder.write(name, bytes), {1, 1, 1}, Normals::smooth, reflectivity);
}

// The largest differences of two meshes of the same vertices, in the unit of `step`.
void check_equal(const Mesh& got, const Mesh& wanted, double position_step, double normal_step,
                 double uv_step) {
  REQUIRE(got.vertices.size() == wanted.vertices.size());
  REQUIRE(got.normals.size() == wanted.normals.size());
  CHECK(got.triangles == wanted.triangles);
  for (std::size_t v = 0; v < got.vertices.size(); ++v) {
    CHECK(length(to_vec3(got.vertices[v]) - to_vec3(wanted.vertices[v])) <
          0.9 * position_step + 1e-6);
    CHECK(length(to_vec3(got.normals[v]) - to_vec3(wanted.normals[v])) < 0.9 * normal_step + 1e-6);
    for (std::size_t i = 0; i < 2; ++i)
      CHECK(std::abs(got.uv[v][i] - wanted.uv[v][i]) < 0.6 * uv_step + 1e-6);
  }
}

const std::string kQuantized =
    R"("extensionsUsed": ["KHR_mesh_quantization", "KHR_texture_transform"], "extensionsRequired": ["KHR_mesh_quantization"], )";

// Six digits would not do.
std::string number_text(double value) { return std::to_string(1e9 * value) + "e-9"; }

std::string uv_transform(double scale) {
  const std::string text = number_text(scale);
  return R"("baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0, 0], "scale": [)" +
         text + ", " + text + "]}}}";
}

}  // namespace

// A node makes meters of positions that are stored as steps, as gltfpack does, and the material's
// transform makes texture coordinates.
TEST_CASE("whole numbers of every type are as good as floats to their step") {
  const TemporaryFolder folder;
  struct Type {
    int component;
    double largest;
  };
  for (const auto& [component, largest] :
       {Type{5120, 127}, Type{5121, 255}, Type{5122, 32767}, Type{5123, 65535}}) {
    const bool is_signed = component == 5120 || component == 5122;
    const auto all = vertices(is_signed);
    const double step = 1 / largest;
    for (const bool normalized : {true, false}) {
      INFO("component " << component << (normalized ? " normalized" : ""));
      // Of stored numbers or of numbers from -1 to 1, to a body of 3 m.
      const double scale = 3 * (normalized ? 1 : step);
      const auto node = [](double factor) {
        const std::string text = number_text(factor);
        return R"(, "translation": [1, 2, 3], "rotation": [0, 0, 0.6, 0.8], "scale": [)" + text +
               ", " + text + ", " + text + "]";
      };
      File file;
      file.node = node(scale);
      file.extensions = kQuantized;
      file.position = file.uv = {component, normalized, step};
      const int normal_type = component < 5122 ? 5120 : 5122;
      file.normal = {normal_type, true, normal_type == 5120 ? 1.0 / 127 : 1.0 / 32767};
      if (!normalized) file.material = uv_transform(step);
      File floats;
      floats.node = node(3);
      const auto wanted = gltf_mesh(folder, "float.glb", glb_of(floats, all));
      REQUIRE(wanted.ok());
      for (const auto& [name, bytes] :
           {std::pair{"a.glb", glb_of(file, all)}, {"a.gltf", gltf_of(file, all)}}) {
        const auto mesh = gltf_mesh(folder, name, bytes);
        INFO(name << (mesh.ok() ? "" : mesh.error().message));
        REQUIRE(mesh.ok());
        check_equal(*mesh, *wanted, 3 * step, file.normal.step, step);
      }
    }
  }
}

TEST_CASE("the texture coordinates of a material are moved, turned and scaled") {
  const TemporaryFolder folder;
  const auto plain = gltf_mesh(folder, "a.glb", glb_of(File{}));
  File turned;
  turned.material =
      R"("baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0.25], "rotation": 1.5707963267948966, "scale": [2, 3]}}})";
  const auto mesh = gltf_mesh(folder, "b.glb", glb_of(turned));
  REQUIRE(plain.ok());
  REQUIRE(mesh.ok());
  for (std::size_t v = 0; v < mesh->uv.size(); ++v) {  // v is down in the file
    const double u_down = plain->uv[v][0], v_down = 1 - plain->uv[v][1];
    CHECK(mesh->uv[v][0] == Approx(3 * v_down + 0.5).margin(1e-5));
    CHECK(1 - mesh->uv[v][1] == Approx(-2 * u_down + 0.25).margin(1e-5));
  }
  // What is not asked for does not cost anything.
  CHECK(gltf_mesh(folder, "b.glb", glb_of(turned), MeshReflectivity::material)->uv.empty());
}

// A sparse accessor over nothing: vertex 2 alone is not at the origin.
TEST_CASE("sparse whole numbers are read") {
  const TemporaryFolder folder;
  std::string bytes;
  for (const int i : {1, 2, 3}) put_value(bytes, static_cast<std::uint16_t>(i));
  for (const int x : {40, 0, 0, 0, 50, 0, 0, 0, 60}) put_value(bytes, static_cast<std::int8_t>(x));
  for (const int i : {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3})
    put_value(bytes, static_cast<std::uint8_t>(i));
  const auto json = [](int changed_count, int last) {
    return R"({"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_mesh_quantization"], "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
"accessors": [{"componentType": 5120, "count": )" +
           std::to_string(last) + R"(, "type": "VEC3", "sparse": {"count": )" +
           std::to_string(changed_count) +
           R"(, "indices": {"bufferView": 0, "componentType": 5123}, "values": {"bufferView": 1}}},
{"bufferView": 2, "componentType": 5121, "count": 12, "type": "SCALAR"}],
"bufferViews": [{"buffer": 0, "byteLength": 6}, {"buffer": 0, "byteOffset": 6, "byteLength": 9}, {"buffer": 0, "byteOffset": 15, "byteLength": 12}],
"buffers": [{"byteLength": 27}]})";
  };
  const auto mesh =
      gltf_mesh(folder, "a.glb", glb_of(json(3, 4), bytes), MeshReflectivity::material);
  INFO((mesh.ok() ? "" : mesh.error().message));
  REQUIRE(mesh.ok());
  const auto has = [&](std::array<float, 3> wanted) {
    return std::find(mesh->vertices.begin(), mesh->vertices.end(), wanted) != mesh->vertices.end();
  };
  CHECK((has({40, 0, 0}) && has({0, 0, 50}) && has({0, -60, 0}) && has({0, 0, 0})));  // z up
  const auto more =
      gltf_mesh(folder, "more.glb", glb_of(json(4, 4), bytes), MeshReflectivity::material);
  CHECK(is_refused(more, "more.glb: accessor 0 ends beyond its buffer; the file is damaged"));
  const auto beyond =
      gltf_mesh(folder, "beyond.glb", glb_of(json(3, 3), bytes), MeshReflectivity::material);
  CHECK(is_refused(beyond, "accessor 0 changes vertex 3 of 3"));
}

TEST_CASE("extensions that a glTF file requires are refused by name unless they do not matter") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& names) {
    File file;
    file.extensions =
        R"("extensionsUsed": [)" + names + R"(], "extensionsRequired": [)" + names + "], ";
    return gltf_mesh(folder, "a.glb", glb_of(file));
  };
  CHECK(is_refused(
      read(R"("EXT_meshopt_compression")"),
      "a.glb: requires EXT_meshopt_compression, which is not supported; export it without",
      ErrorKind::usage));
  CHECK(is_refused(read(R"("KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "VENDOR_shape")"),
                   "requires EXT_mesh_gpu_instancing, VENDOR_shape, which"));
  for (const char* looks : {"KHR_materials_unlit", "KHR_texture_basisu", "EXT_texture_webp",
                            "KHR_lights_punctual", "KHR_texture_transform"}) {
    INFO(looks);
    CHECK(read('"' + std::string(looks) + '"').ok());
  }
  // Data that its reader cannot unpack.
  File draco;
  draco.extensions = R"("extensionsRequired": ["KHR_draco_mesh_compression"], )";
  std::string bytes = glb_of(draco);
  const std::string indices = R"("indices": 3)";
  bytes.replace(bytes.find(indices), indices.size(), R"("indices":99)");
  CHECK(is_refused(gltf_mesh(folder, "d.glb", bytes), "it requires KHR_draco_mesh_compression"));
}

TEST_CASE("accessors that lie about their bytes are refused") {
  const TemporaryFolder folder;
  File file;
  file.position = {5122, false, 1.0 / 32767};
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string bytes = gltf_of(file, vertices(true));
    const std::size_t at = bytes.find(from);
    REQUIRE(at != std::string::npos);
    return gltf_mesh(folder, "a.gltf", bytes.replace(at, from.size(), to));
  };
  CHECK(changed(R"("count": 4)", R"("count": 3)").ok() == false);  // a face has vertex 3
  CHECK(is_refused(changed(R"("count": 4)", R"("count": 5)"), "accessor 0 ends beyond its buffer"));
  CHECK(is_refused(changed(R"("count": 4)", R"("count": 99999999999)"),
                   "accessor 0 claims 99999999999 vertices"));
  CHECK(is_refused(changed(R"("byteOffset": 0)", R"("byteOffset": 9999)"),
                   "accessor 0 ends beyond its buffer"));
  CHECK(is_refused(changed(R"("componentType": 5122)", R"("componentType": 5125)"),
                   "accessor 0 has the type VEC3 of components 5125"));
}

// Protects data sets from bodies that nobody made: the unit, or a number that was read wrongly.
TEST_CASE("a body of more than 1000 km or of numbers that are not finite is refused") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& factor) {
    File file;
    file.node = R"(, "scale": [)" + factor + ", " + factor + ", " + factor + "]";
    return gltf_mesh(folder, "a.glb", glb_of(file));
  };
  CHECK(read("4e5").ok());
  CHECK(is_refused(read("1e6"),
                   "a.glb: is 1.9e+06 x 1.55e+06 x 1.75e+06 m large; expected at most 1000 km",
                   ErrorKind::usage));
  CHECK(is_refused(read("1e30"), "expected at most 1000 km: set scale to the file's unit"));
  CHECK(is_refused(read("1e39"), "is not a finite number"));
}
