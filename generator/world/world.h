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
#include "core/material.h"
#include "core/ping.h"
#include "core/vec.h"
#include "scenario/scenario.h"
#include "world/mesh.h"
#include "world/shapes.h"
#include "world/volumes.h"

namespace ensonify {

struct MeshShape {
  std::shared_ptr<const Mesh> mesh;
};
using Shape = std::variant<BoxShape, SphereShape, CylinderShape, PlaneShape, MeshShape>;

struct WorldObject {
  std::uint32_t instance = 0;
  Shape shape;
  Pose pose;  // in the world
  Material material;
};

struct PointTarget {
  std::uint32_t instance = 0;
  Vec3 position_m;  // in the world
  double target_strength_db = 0;
};

struct World {
  std::vector<WorldObject> objects;
  std::vector<PointTarget> point_targets;
  std::vector<Volume> volumes;
  std::vector<School> schools;
  std::vector<Instance> instances;   // instance id k is instances[k - 1]
  std::vector<std::string> classes;  // class id k is classes[k - 1], in order of appearance
};

// Reads every mesh, table and density once. Errors: those of load_mesh, load_backscatter_table and
// make_volume, of all materials, objects and volumes at once, each line behind the key that names
// the file; usage, or io where nothing is wrong but the reading.
Result<World> build_world(const Scenario& scenario, std::uint32_t sequence = 0);

}  // namespace ensonify
