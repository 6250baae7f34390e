// The immutable world of one sequence: what can be hit, where it stands and how it scatters.
//
//   World        objects, point targets, and their ids as instances
//   build_world  empty_world   scenario -> World
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

// Fills all the water with scatterers of one strength.
struct UniformVolume {
  std::uint32_t instance = 0;
  double strength_per_m = 0;  // s_v, backscatter cross-section of a unit of volume per steradian
};

struct World {
  std::vector<WorldObject> objects;
  std::vector<PointTarget> point_targets;
  std::vector<UniformVolume> volumes;
  std::vector<Instance> instances;   // instance id k is instances[k - 1]
  std::vector<std::string> classes;  // class id k is classes[k - 1], in order of appearance
};

// Reads every mesh, terrain and table once. Errors: those of load_mesh, load_height_grid,
// vertex_reflectivity and load_backscatter_table, of all materials and objects at once, each line
// behind the key that names the file; usage, or io where nothing is wrong but the reading.
// Procedural terrain is drawn by seed, sequence and name. What the scenario leaves to be placed is
// placed for `sequence`; usage where there is no room.
Result<World> build_world(const Scenario& scenario, std::uint32_t sequence = 0);

// Its instances and classes alone, without materials; reads no file.
World empty_world(const Scenario& scenario);

}  // namespace ensonify
