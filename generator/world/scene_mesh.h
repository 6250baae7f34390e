// The surfaces of a world as triangles, and the files that hold them.
//
//   tessellated                closed-form shapes as triangles
//   SceneReach  SceneObject  scene_objects   every object with its mesh and pose
//   SceneSize  scene_size  scene_fits        bytes of the files, and whether they can have them
//   write_scene_ply  write_scene_glb         in the world frame; by object, for viewers
//
// Point targets, volumes and schools have no surfaces and are left out.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/vec.h"
#include "world/world.h"

namespace ensonify {

// Vertices lie on the shape. Triangles are counterclockwise as seen from where the shape is not
// solid: from outside, or from inside a room. They lie at most kChordOfRadius radii from the shape.
Mesh tessellated(const BoxShape& box);
Mesh tessellated(const SphereShape& sphere);
Mesh tessellated(const CylinderShape& cylinder);

// Where sonars are in the world, and how far they reach.
struct SceneReach {
  std::vector<Vec3> sonars_m;
  double range_m = 0;
};

// The part of the plane z = 0 of `pose` within reach: the smallest rectangle along its axes around
// the circles in which it cuts the spheres of the reach. None if it cuts no sphere.
std::optional<Mesh> tessellated(const PlaneShape& plane, const Pose& pose, const SceneReach& reach);

struct SceneObject {
  const WorldObject* object = nullptr;
  std::shared_ptr<const Mesh> mesh;  // in the object's frame; one for all objects of equal shape
  Pose pose;                         // in the world
};

// The objects of the world at these poses, one per object; planes out of reach are left out. Meshes
// and terrain are those of the world. `world` must outlive the result.
std::vector<SceneObject> scene_objects(const World& world, std::span<const Pose> object_in_world,
                                       const SceneReach& reach);

// Without the text of the headers, which have some hundred bytes for each object.
struct SceneSize {
  std::uint64_t vertices = 0;  // in the PLY file
  std::uint64_t ply_bytes = 0, glb_bytes = 0;
};
SceneSize scene_size(const World& world);

// Error (usage): more than 2^31 vertices, or more than 4 GB of meshes as glTF.
Status scene_fits(const World& world);

using AppendBytes = std::function<void(std::string_view)>;

// Binary little-endian PLY: vertices x, y, z (double, world, m), faces with the list vertex_indices
// (uchar, int), instance (ushort) and class (uchar). Comments name the instances. Equal input gives
// equal bytes; needs scene_fits().
void write_scene_ply(const World& world, std::span<const SceneObject> objects,
                     const AppendBytes& append);

// Binary glTF 2.0: the node `y_up` turns z up to glTF's y up, so that its children have the poses
// of the objects in the world; `extras` of a child has instance, class, class_id, material and
// moves. Positions are floats in the frames of the objects. Equal input gives equal bytes; needs
// scene_fits().
void write_scene_glb(const World& world, std::span<const SceneObject> objects,
                     const AppendBytes& append);

}  // namespace ensonify
