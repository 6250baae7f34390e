// The immutable world of one sequence: what can be hit, where it stands and how it scatters.
//
//   World        objects, point targets, and their ids as instances
//   build_world  scenario -> World
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/error.h"
#include "core/ping.h"
#include "core/vec.h"
#include "scenario/scenario.h"
#include "world/mesh.h"
#include "world/shapes.h"

namespace ensonify {

struct MeshShape {
  std::shared_ptr<const Mesh> mesh;
};
using Shape = std::variant<BoxShape, SphereShape, CylinderShape, PlaneShape, MeshShape>;

struct WorldObject {
  std::uint32_t instance = 0;
  Shape shape;
  Pose pose;  // in the world
  double reflectivity = 0;
};

struct PointTarget {
  std::uint32_t instance = 0;
  Vec3 position_m;  // in the world
  double target_strength_db = 0;
};

struct World {
  std::vector<WorldObject> objects;
  std::vector<PointTarget> point_targets;
  std::vector<Instance> instances;   // instance id k is instances[k - 1]
  std::vector<std::string> classes;  // class id k is classes[k - 1], in order of appearance
};

// Reads every mesh once. Errors (usage): those of load_mesh, of all objects at once, each behind
// the key that names the file.
Result<World> build_world(const Scenario& scenario);

}  // namespace ensonify
