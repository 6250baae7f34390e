// The world as Embree sees it.
//
//   Scene  build_scene
//   Query  rays under way
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "trace/embree.h"
#include "trace/tracer.h"
#include "world/world.h"

namespace ensonify {

// Nearer than this is the surface that the sonar itself touches.
inline constexpr double kNearestHit_m = 1e-6;

struct Scene;

// What Embree's callbacks know of a closed form.
struct ClosedForm {
  const Scene* scene = nullptr;
  const WorldObject* object = nullptr;
};

struct Scene {
  // Embree computes in float: at map coordinates (a northing of 4.5e6 m) its steps are half a
  // metre. So it sees everything from the first object.
  Vec3 origin_m;
  std::vector<std::unique_ptr<ClosedForm>> closed_forms;
  RTCDevice device = nullptr;
  RTCScene top = nullptr;
  std::vector<RTCScene> mesh_scenes;
  std::vector<const WorldObject*> planes;       // without end: outside any box
  std::vector<const WorldObject*> by_geometry;  // object of each geometry of `top`

  Scene() = default;
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
};

// `world` must outlive the scene. Throws as the constructor of Tracer.
void build_scene(const World& world, Scene& scene);

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

// Rays from one place, under way. It carries them in double to the callbacks of the closed forms;
// RTCRay::id is a ray's place here.
struct Query {
  EmbreeContext context;                  // first: Embree hands back a pointer to it
  Vec3 origin_m;                          // in the world
  const LocalOrigins* origins = nullptr;  // the same in all frames, where known
  Directions directions;
  ClosedFormHit* closed_form = nullptr;  // one a ray
};

// Where a query's rays start, and one of them, in the frame of geometry `geometry`.
Vec3 local_origin(const Scene& scene, const Query& query, unsigned geometry);
Ray local_ray(const Scene& scene, const Query& query, unsigned ray, unsigned geometry);

// The nearest hit of a closed form, given in its frame; a mesh has none.
std::optional<SurfaceHit> intersect_closed_form(const Shape& shape, const Ray& local);

}  // namespace ensonify
