#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>

#include "formats/bytes.h"
#include "formats/json.h"
#include "world/scene_mesh.h"

namespace ensonify {
namespace {

constexpr std::size_t kPieceBytes = std::size_t{1} << 20;

// Passes bytes on in pieces of about a megabyte.
class Pieces {
 public:
  explicit Pieces(const AppendBytes& append) : append_(append) {}
  ~Pieces() { append_(bytes_); }
  Pieces(const Pieces&) = delete;
  Pieces& operator=(const Pieces&) = delete;

  template <class T>
  void put(T value) {
    put_value(bytes_, value);
    if (bytes_.size() < kPieceBytes) return;
    append_(bytes_);
    bytes_.clear();
  }

 private:
  const AppendBytes& append_;
  std::string bytes_;
};

const Instance& instance_of(const World& world, const SceneObject& object) {
  return world.instances[object.object->instance - 1];
}

std::string ply_head(const World& world, std::span<const SceneObject> objects) {
  std::uint64_t vertices = 0, faces = 0;
  std::string comments;
  for (const SceneObject& object : objects) {
    const Instance& instance = instance_of(world, object);
    vertices += object.mesh->vertices.size();
    faces += object.mesh->triangles.size();
    // Names of scenarios are on one line.
    comments += fmt::format("comment instance {} class {} {} {}\n", instance.id, instance.class_id,
                            instance.class_name, instance.name);
  }
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment meters in the world frame, z up\n{}"
      "element vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
      "element face {}\nproperty list uchar int vertex_indices\nproperty ushort instance\n"
      "property uchar class\nend_header\n",
      comments, vertices, faces);
}

// The meshes of the objects, each once, in the order of their first objects.
struct DistinctMeshes {
  std::vector<const Mesh*> meshes;
  std::map<const Mesh*, std::size_t> number;

  explicit DistinctMeshes(std::span<const SceneObject> objects) {
    for (const SceneObject& object : objects) {
      const Mesh* const mesh = object.mesh.get();
      if (number.try_emplace(mesh, meshes.size()).second) meshes.push_back(mesh);
    }
  }
};

constexpr std::uint64_t kVectorBytes = 3 * sizeof(float);

bool has_normals(const Mesh& mesh) { return mesh.normals.size() == mesh.vertices.size(); }

std::uint64_t glb_bytes(const Mesh& mesh) {
  return (mesh.vertices.size() * (has_normals(mesh) ? 2 : 1) + mesh.triangles.size()) *
         kVectorBytes;
}

// The arrays of glTF that describe the binary data of meshes.
struct GlbArrays {
  Json meshes = Json::array(), accessors = Json::array(), views = Json::array();
  std::uint64_t bytes = 0;

  std::size_t add(std::uint64_t count, int component, const char* type, int target,
                  std::uint64_t size, Json more = Json::object()) {
    views.push_back(
        {{"buffer", 0}, {"byteOffset", bytes}, {"byteLength", size}, {"target", target}});
    Json accessor = {{"bufferView", views.size() - 1},
                     {"componentType", component},
                     {"count", count},
                     {"type", type}};
    accessor.update(more);
    accessors.push_back(std::move(accessor));
    bytes += size;
    return accessors.size() - 1;
  }

  void add(const Mesh& mesh) {
    constexpr int kFloat = 5126, kUnsigned = 5125, kVertices = 34962, kIndices = 34963;
    Bounds bounds;
    for (const auto& v : mesh.vertices) bounds.add(to_vec3(v));
    const std::uint64_t vertices = mesh.vertices.size(), triangles = mesh.triangles.size();
    Json attributes = {
        {"POSITION", add(vertices, kFloat, "VEC3", kVertices, vertices * kVectorBytes,
                         {{"min", json_of(bounds.low)}, {"max", json_of(bounds.high)}})}};
    if (has_normals(mesh)) {
      attributes["NORMAL"] = add(vertices, kFloat, "VEC3", kVertices, vertices * kVectorBytes);
    }
    const std::size_t indices =
        add(3 * triangles, kUnsigned, "SCALAR", kIndices, triangles * kVectorBytes);
    const Json primitive = {{"attributes", attributes}, {"indices", indices}, {"material", 0}};
    meshes.push_back({{"primitives", Json::array({primitive})}});
  }
};

Json node_of(const World& world, const SceneObject& object, std::size_t mesh) {
  const Instance& instance = instance_of(world, object);
  const Quat q = object.pose.rotation;
  return {{"name", instance.name},
          {"mesh", mesh},
          {"translation", json_of(object.pose.position_m)},
          {"rotation", {q.x, q.y, q.z, q.w}},
          {"extras",
           {{"instance", instance.id},
            {"class", instance.class_name},
            {"class_id", instance.class_id},
            {"material", instance.material},
            {"moves", object.object->path != nullptr}}}};
}

// The world's z becomes glTF's y, and the world's y its -z. trimesh takes a node `world` for its
// own root, and would leave its rotation out.
Json root_node(std::size_t children) {
  const double s = std::numbers::sqrt2 / 2;
  Json node = {{"name", "y_up"}, {"rotation", {-s, 0.0, 0.0, s}}};
  for (std::size_t child = 1; child <= children; ++child) node["children"].push_back(child);
  return node;
}

Json glb_json(const World& world, std::span<const SceneObject> objects,
              const DistinctMeshes& distinct) {
  Json nodes = Json::array({root_node(objects.size())});
  for (const SceneObject& object : objects) {
    nodes.push_back(node_of(world, object, distinct.number.at(object.mesh.get())));
  }
  Json json = {{"asset", {{"version", "2.0"}, {"generator", "ensonify"}}},
               {"scene", 0},
               {"scenes", Json::array({{{"nodes", {0}}}})},
               {"nodes", std::move(nodes)}};
  if (objects.empty()) return json;  // empty arrays are not valid
  GlbArrays arrays;
  for (const Mesh* mesh : distinct.meshes) arrays.add(*mesh);
  json["meshes"] = std::move(arrays.meshes);
  // Planes and terrain are seen from both sides.
  json["materials"] =
      Json::array({{{"name", "surface"},
                    {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}},
                    {"doubleSided", true}}});
  json["accessors"] = std::move(arrays.accessors);
  json["bufferViews"] = std::move(arrays.views);
  json["buffers"] = Json::array({{{"byteLength", arrays.bytes}}});
  return json;
}

void put_chunk_head(Pieces& pieces, std::uint64_t bytes, const char* kind) {
  pieces.put(static_cast<std::uint32_t>(bytes));
  for (int i = 0; i < 4; ++i) pieces.put(kind[i]);
}

}  // namespace

void write_scene_ply(const World& world, std::span<const SceneObject> objects,
                     const AppendBytes& append) {
  append(ply_head(world, objects));
  Pieces pieces(append);
  for (const SceneObject& object : objects) {
    for (const auto& vertex : object.mesh->vertices) {
      const Vec3 p = transform_point(object.pose, to_vec3(vertex));
      for (const double value : {p.x, p.y, p.z}) pieces.put(value);
    }
  }
  std::int32_t first = 0;
  for (const SceneObject& object : objects) {
    const Instance& instance = instance_of(world, object);
    for (const auto& triangle : object.mesh->triangles) {
      pieces.put(std::uint8_t{3});
      for (const std::uint32_t vertex : triangle) {
        pieces.put(first + static_cast<std::int32_t>(vertex));
      }
      pieces.put(instance.id);
      pieces.put(instance.class_id);
    }
    first += static_cast<std::int32_t>(object.mesh->vertices.size());
  }
}

void write_scene_glb(const World& world, std::span<const SceneObject> objects,
                     const AppendBytes& append) {
  const DistinctMeshes distinct(objects);
  std::string text = json_line(glb_json(world, objects, distinct));
  while (text.size() % 4 != 0) text += ' ';
  std::uint64_t bytes = 0;
  for (const Mesh* mesh : distinct.meshes) bytes += glb_bytes(*mesh);
  constexpr std::uint64_t kHead = 12, kChunkHead = 8;
  const std::uint64_t whole =
      kHead + kChunkHead + text.size() + (bytes > 0 ? kChunkHead + bytes : 0);
  ENSONIFY_ASSERT(whole <= std::numeric_limits<std::uint32_t>::max());
  Pieces pieces(append);
  put_chunk_head(pieces, 0x46546C67, "\2\0\0\0");  // the magic number "glTF", and version 2
  pieces.put(static_cast<std::uint32_t>(whole));
  put_chunk_head(pieces, text.size(), "JSON");
  for (const char c : text) pieces.put(c);
  if (bytes == 0) return;
  put_chunk_head(pieces, bytes, "BIN\0");
  const auto put_vectors = [&](const auto& vectors) {
    for (const auto& vector : vectors) {
      for (const auto value : vector) pieces.put(value);
    }
  };
  for (const Mesh* mesh : distinct.meshes) {
    put_vectors(mesh->vertices);
    if (has_normals(*mesh)) put_vectors(mesh->normals);
    put_vectors(mesh->triangles);
  }
}

}  // namespace ensonify
