// The world as a scene of Embree, and the rays that are traced through it.
//
//   MeshHierarchies  build_hierarchies   independent of poses
//   Scene            build_scene         all objects at one moment
//   bounds_of  new_scene  commit         steps of building it
//   Layers           hits along one ray
//   Query            one_ray  local_origins  local_ray   rays that are being traced
//   intersect_closed_form
#pragma once

#include <array>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "trace/embree.h"
#include "trace/hits.h"
#include "world/world.h"

namespace ensonify {

// How far Embree searches, in float, for hits up to a range in double.
inline float float_range(double range_m) { return static_cast<float>(range_m) * 1.000001f; }

// Nearer hits are ignored, because they lie on a surface that the sonar itself touches.
inline constexpr double kNearestHit_m = 1e-6;

// Embree's device and one hierarchy per mesh, which all objects with that mesh share.
struct MeshHierarchies {
  RTCDevice device = nullptr;
  std::unordered_map<const Mesh*, RTCScene> scenes;
  // Scenes of one device are built one after the other, because Embree passes memory from one to
  // the next.
  mutable std::mutex building;

  MeshHierarchies() = default;
  ~MeshHierarchies();
  MeshHierarchies(const MeshHierarchies&) = delete;
  MeshHierarchies& operator=(const MeshHierarchies&) = delete;
};

// An object with its pose at that moment.
struct PlacedObject {
  const WorldObject* object = nullptr;
  Pose pose;
};

struct Scene;

// The data that Embree passes to the callbacks of a closed form.
struct ClosedForm {
  const Scene* scene = nullptr;
  PlacedObject placed;
};

// All objects at one moment.
struct Scene {
  std::shared_ptr<const MeshHierarchies> meshes;
  // The position of the first object, to which Embree's coordinates are relative. Embree computes
  // in float, whose steps at map coordinates (a northing of 4.5e6 m) are half a meter.
  Vec3 origin_m;
  std::deque<ClosedForm> closed_forms;  // Embree keeps their addresses
  RTCScene top = nullptr;
  std::vector<PlacedObject> planes;       // infinite, so not in `top`
  std::vector<PlacedObject> by_geometry;  // object of each geometry of `top`
  std::vector<PlacedObject> uneven;  // by instance id, as far as fields go; empty: none has any

  Scene() = default;
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
};

// The pose of each object in `world`.
std::vector<Pose> own_poses(const World& world);

// `world` must outlive what is built. Both functions throw like the constructor of Tracer.
std::shared_ptr<const MeshHierarchies> build_hierarchies(const World& world);
// One pose per object. Several scenes may be built from the same hierarchies at once.
void build_scene(const World& world, std::span<const Pose> object_in_world,
                 std::shared_ptr<const MeshHierarchies> meshes, Scene& scene);

// The box around an object for Embree, wider than float rounding. Not for planes.
RTCBounds bounds_of(const Scene& scene, const PlacedObject& placed);

// Both throw like the constructor of Tracer. Embree builds on the caller's thread.
RTCScene new_scene(RTCDevice device);
void commit(RTCDevice device, RTCScene part);

// A point in the frame of each object, computed once if many rays start there.
struct LocalOrigins {
  std::vector<Vec3> geometries_m;  // as by_geometry
  std::vector<Vec3> planes_m;
};
LocalOrigins local_origins(const Scene& scene, Vec3 origin_m);

// Most rays in a packet.
inline constexpr int kMostRays = 16;

// Unit vectors in the world, in separate arrays so that the compiler computes several at once.
struct Directions {
  alignas(64) std::array<double, kMostRays> x, y, z;

  Vec3 operator[](unsigned ray) const { return {x[ray], y[ray], z[ray]}; }
};

// The last hit of a ray on a closed form.
struct ClosedFormHit {
  SurfaceHit surface;
  Vec3 local_direction;
};

// The nearest hits along one ray, one per instance, by range, then id.
struct Layers {
  std::uint32_t skip = 0;  // the instance that is transparent; 0: none
  int most = kMostLayers;
  double range_max_m = 0;
  int count = 0;
  std::array<Hit, kMostLayers> hits;
};

// Rays from one point that are being traced. Gives them in double precision to the callbacks of the
// closed forms; RTCRay::id is the index of a ray here.
struct Query {
  EmbreeContext context;                  // first: callbacks get a pointer to it
  Vec3 origin_m;                          // in the world
  const LocalOrigins* origins = nullptr;  // origin_m in all frames; may be null
  Directions directions;
  ClosedFormHit* closed_form = nullptr;  // one per ray
  Layers* layers = nullptr;              // one per ray, if all surfaces along it are wanted
};

// Sets up the query of a single ray, and returns the ray in Embree's form.
RTCRayHit one_ray(const Scene& scene, const Ray& ray, double range_max_m, Query& query);

// The start of a query's rays, and one of the rays, in the frame of geometry `geometry`.
Vec3 local_origin(const Scene& scene, const Query& query, unsigned geometry);
Ray local_ray(const Scene& scene, const Query& query, unsigned ray, unsigned geometry);

// The nearest hit on a closed form, in its frame; none for a mesh.
std::optional<SurfaceHit> intersect_closed_form(const Shape& shape, const Ray& local);

}  // namespace ensonify
