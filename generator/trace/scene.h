// The world as Embree sees it, and from what Embree says back to double precision.
//
//   MeshHierarchies  build_hierarchies   what stays, whatever moves
//   Scene            build_scene         all objects at one moment
//   bounds_of  new_scene  commit         parts of building it
//   Query            rays in work
//   Found  refine                        of the nearest surface of all
//   refine_on_mesh  hit_of  plane_hit    of one object
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
#include "trace/tracer.h"
#include "world/world.h"

namespace ensonify {

// What Embree looks as far as, in float, for hits up to a range in double.
inline float float_range(double range_m) { return static_cast<float>(range_m) * 1.000001f; }

// Nearer than this is the surface that the sonar itself touches.
inline constexpr double kNearestHit_m = 1e-6;

// Embree's device and one hierarchy a mesh, wherever and however often it stands.
struct MeshHierarchies {
  RTCDevice device = nullptr;
  std::unordered_map<const Mesh*, RTCScene> scenes;
  // Scenes of one device are built one after the other: Embree hands memory from one to the next.
  mutable std::mutex building;

  MeshHierarchies() = default;
  ~MeshHierarchies();
  MeshHierarchies(const MeshHierarchies&) = delete;
  MeshHierarchies& operator=(const MeshHierarchies&) = delete;
};

// An object where it stands at the moment.
struct PlacedObject {
  const WorldObject* object = nullptr;
  Pose pose;
};

struct Scene;

// What Embree's callbacks know of a closed form.
struct ClosedForm {
  const Scene* scene = nullptr;
  PlacedObject placed;
};

// One moment.
struct Scene {
  std::shared_ptr<const MeshHierarchies> meshes;
  // Embree computes in float: at map coordinates (a northing of 4.5e6 m) its steps are half a
  // metre. So it sees everything from the first object.
  Vec3 origin_m;
  std::deque<ClosedForm> closed_forms;  // Embree keeps their addresses
  RTCScene top = nullptr;
  std::vector<PlacedObject> planes;       // without end: outside any box
  std::vector<PlacedObject> by_geometry;  // object of each geometry of `top`
  std::vector<PlacedObject> uneven;       // by instance id, as far as fields go; empty: none has any

  Scene() = default;
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
};

// Where each object says that it is.
std::vector<Pose> own_poses(const World& world);

// `world` must outlive what is built. Both throw as the constructor of Tracer.
std::shared_ptr<const MeshHierarchies> build_hierarchies(const World& world);
// One pose an object. Several may be built from the same hierarchies at once.
void build_scene(const World& world, std::span<const Pose> object_in_world,
                 std::shared_ptr<const MeshHierarchies> meshes, Scene& scene);

// The box about an object, as Embree wants it: wider than a float can round away. Not of planes.
RTCBounds bounds_of(const Scene& scene, const PlacedObject& placed);

// Throw as the constructor of Tracer. Embree builds on the caller's thread.
RTCScene new_scene(RTCDevice device);
void commit(RTCDevice device, RTCScene part);

// A place in the frame of each object: told once where many rays start there.
struct LocalOrigins {
  std::vector<Vec3> geometries_m;  // as by_geometry
  std::vector<Vec3> planes_m;
};
LocalOrigins local_origins(const Scene& scene, Vec3 origin_m);

// As many rays as go together.
inline constexpr int kMostRays = 16;

// Unit vectors in the world, side by side, so that the compiler computes several at once.
struct Directions {
  alignas(64) std::array<double, kMostRays> x, y, z;

  Vec3 operator[](unsigned ray) const { return {x[ray], y[ray], z[ray]}; }
};

// The last closed form that a ray was found to meet.
struct ClosedFormHit {
  SurfaceHit surface;
  Vec3 local_direction;
};

struct Layers;  // trace/packets.h

// Rays from one place, in work. It carries them in double to the callbacks of the closed forms;
// RTCRay::id is a ray's place here.
struct Query {
  EmbreeContext context;                  // first: Embree hands back a pointer to it
  Vec3 origin_m;                          // in the world
  const LocalOrigins* origins = nullptr;  // the same in all frames, where known
  Directions directions;
  ClosedFormHit* closed_form = nullptr;  // one a ray
  Layers* layers = nullptr;              // one a ray, where all surfaces along it are asked for
};

// A query of one ray alone, and the ray as Embree wants it.
RTCRayHit one_ray(const Scene& scene, const Ray& ray, double range_max_m, Query& query);

// Where a query's rays start, and one of them, in the frame of geometry `geometry`.
Vec3 local_origin(const Scene& scene, const Query& query, unsigned geometry);
Ray local_ray(const Scene& scene, const Query& query, unsigned ray, unsigned geometry);

// Factors and patches of uneven surfaces, by the place of the hit in its object's frame.
void apply_fields(const Scene& scene, const Ray& ray, std::span<Hit> hits);

// The nearest hit of a closed form, given in its frame; a mesh has none.
std::optional<SurfaceHit> intersect_closed_form(const Shape& shape, const Ray& local);

// What Embree says of one ray.
struct Found {
  unsigned geometry = RTC_INVALID_GEOMETRY_ID;  // none: it met nothing
  unsigned instance = RTC_INVALID_GEOMETRY_ID;  // of a mesh: its geometry in the top scene
  unsigned triangle = 0;
  float range_m = 0;
  float u = 0, v = 0;
};

// Range and incidence of the query's rays, one a `found`, in double. Planes, of which Embree knows
// nothing, are looked at here. A ray's hit does not depend on what goes with it.
void refine(const Scene& scene, const Query& query, std::span<const Found> found,
            double range_max_m, Hit* hits);

// The hits of those rays whose `found` is of the mesh at geometry `instance`; others stay.
void refine_on_mesh(const Scene& scene, const Query& query, std::span<const Found> found,
                    unsigned instance, Hit* hits);

// The closed form was met in its own frame.
Hit hit_of(const SurfaceHit& surface, Vec3 local_direction, const PlacedObject& placed);

// The hit on the scene's plane of that number; none where the ray does not meet it.
std::optional<Hit> plane_hit(const Scene& scene, const Query& query, unsigned ray,
                             std::size_t plane);

}  // namespace ensonify
