// The immutable world of one sequence: surfaces, their poses and how they scatter.
//
//   World        objects, point targets, and their ids as instances
//   MeshLibrary  build_world  empty_world   scenario -> World
//   FlatReflector  flat_reflectors   planes and boxes of a scenario that mirror sound
//   object_pose  pose of an object at a time
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <variant>
#include <vector>

#include "core/error.h"
#include "core/ping.h"
#include "core/surface.h"
#include "core/vec.h"
#include "world/mesh.h"
#include "world/path.h"
#include "world/reflectivity_image.h"
#include "world/shapes.h"
#include "world/surface_field.h"
#include "world/volumes.h"

namespace ensonify {

struct Scenario;

struct MeshShape {
  std::shared_ptr<const Mesh> mesh;
  bool ground = false;  // terrain: solid below, along -z of its frame
  // Factor on the reflectivity at the texture coordinates of the mesh; null: none.
  std::shared_ptr<const ReflectivityImage> image = nullptr;
};
using Shape = std::variant<BoxShape, SphereShape, CylinderShape, PlaneShape, MeshShape>;

// Whether the shape is seen from inside and contains everything else.
bool is_room(const Shape& shape);

// The response of an elastic body for the sonar of a session (ping/ringing.h): echoes relative to
// that of the center, or per meter of a cylinder's axis, and the share of the energy that they miss.
struct Ringing {
  std::vector<Tap> taps = {};
  double missing = 0;
};

struct WorldObject {
  std::uint32_t instance = 0;
  Shape shape;
  Pose pose;  // in the world; if the object moves: at its start
  Material material;
  std::shared_ptr<const Path> path = nullptr;  // null: at rest
  PartMaterials parts = {};
  ObjectFields fields = {};  // by Hit::part; empty: even surfaces
  Ringing ringing = {};      // of an elastic body
};

struct PointTarget {
  std::uint32_t instance = 0;
  Vec3 position_m;  // in the world
  double target_strength_db = 0;
  Ringing ringing = {};  // of an elastic sphere, in place of the strength
};

struct World {
  std::vector<WorldObject> objects;
  std::vector<PointTarget> point_targets;
  std::vector<Volume> volumes;
  std::vector<School> schools;
  std::vector<Instance> instances;   // instance id k is instances[k - 1]
  std::vector<std::string> classes;  // class id k is classes[k - 1], in order of appearance
  // Repairs of the input files, each with its key; nothing is printed here.
  std::vector<std::string> warnings;
  std::vector<std::string> left_out;  // names of objects of the scenario without room in the world
};

// Meshes and images of files, shared by worlds. May be used from several threads at once.
class MeshLibrary {
 public:
  // The mesh with that key, loaded if missing; errors are not kept.
  Result<std::shared_ptr<const Mesh>> mesh(const std::string& key,
                                           const std::function<Result<Mesh>()>& load);
  // The same for the image of a file.
  Result<std::shared_ptr<const ReflectivityImage>> image(const std::filesystem::path& file);

 private:
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const Mesh>> meshes_;
  std::map<std::string, std::shared_ptr<const ReflectivityImage>> images_;
};

// Reads every mesh, image, terrain and table once. Errors: those of load_mesh,
// load_reflectivity_image, load_height_grid, vertex_reflectivity, load_path and
// load_backscatter_table, for all materials and objects at once.
// Each line begins with the key that names the file. The kind is usage, or io if all are reading
// errors. A part that a mesh does not have is a usage error. Synthetic terrain is sampled by seed,
// sequence, redraw and name. Places objects (place.h), with the errors of place_objects. `library`
// is shared by worlds that read the same files, and may be null.
Result<World> build_world(const Scenario& scenario, std::uint32_t sequence = 0,
                          MeshLibrary* library = nullptr);

// A world with only instances and classes, without materials. Reads no files.
World empty_world(const Scenario& scenario);

// A plane or box of a kirchhoff material, which mirrors sound.
struct FlatReflector {
  std::string name;
  std::size_t object = 0;               // in Scenario::objects, and World::objects
  bool is_box = false, inside = false;  // inside: the box is a room
  double reflection = 0, roughness_rms_m = 0;
};

// In the order of the objects, whose names and materials must be those of the world.
std::vector<FlatReflector> flat_reflectors(const Scenario& scenario);

// `time_s` is on the clock of the pings.
Pose object_pose(const WorldObject& object, double time_s);

}  // namespace ensonify
