#include "trace/tracer.h"

#include <cmath>
#include <new>

#include "core/error.h"
#include "core/scatterers.h"
#include "trace/embree.h"

namespace ensonify {
namespace {

// Nearer than this is the surface that the sonar itself touches.
constexpr double kNearestHit_m = 1e-6;

Ray into_frame(const Pose& pose, const Ray& ray) {
  return {inverse_transform_point(pose, ray.origin_m),
          rotate(conjugate(pose.rotation), ray.direction)};
}

// The nearest hit of a closed form; a mesh has none.
std::optional<SurfaceHit> intersect_closed_form(const Shape& shape, const Ray& local) {
  return std::visit(
      [&](const auto& s) -> std::optional<SurfaceHit> {
        if constexpr (std::is_same_v<std::decay_t<decltype(s)>, MeshShape>) {
          return std::nullopt;
        } else {
          return intersect(s, local, kNearestHit_m);
        }
      },
      shape);
}

// What Embree's callbacks know of a closed form.
struct ClosedForm {
  const WorldObject* object = nullptr;
  Vec3 origin_m;  // of Embree's coordinates, in the world
};

// A query carries its ray in double to the callbacks of the closed forms.
struct Query {
  EmbreeContext context;  // first: Embree hands back a pointer to it
  const Ray* ray = nullptr;
};

void closed_form_bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& form = *static_cast<const ClosedForm*>(arguments->geometryUserPtr);
  const WorldObject& object = *form.object;
  Vec3 half{};
  if (const auto* box = std::get_if<BoxShape>(&object.shape)) half = half_extents(*box);
  if (const auto* sphere = std::get_if<SphereShape>(&object.shape)) half = half_extents(*sphere);
  if (const auto* cyl = std::get_if<CylinderShape>(&object.shape)) half = half_extents(*cyl);
  const Vec3 x = rotate(object.pose.rotation, {half.x, 0, 0});
  const Vec3 y = rotate(object.pose.rotation, {0, half.y, 0});
  const Vec3 z = rotate(object.pose.rotation, {0, 0, half.z});
  const Vec3 reach{std::abs(x.x) + std::abs(y.x) + std::abs(z.x),
                   std::abs(x.y) + std::abs(y.y) + std::abs(z.y),
                   std::abs(x.z) + std::abs(y.z) + std::abs(z.z)};
  const Vec3 centre = object.pose.position_m - form.origin_m;
  // Wider by more than a float can round away: the boxes decide what is tested at all.
  const double slack = 1e-5 + 1e-6 * (length(centre) + length(reach));
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = static_cast<float>(centre.x - reach.x - slack);
  bounds.lower_y = static_cast<float>(centre.y - reach.y - slack);
  bounds.lower_z = static_cast<float>(centre.z - reach.z - slack);
  bounds.upper_x = static_cast<float>(centre.x + reach.x + slack);
  bounds.upper_y = static_cast<float>(centre.y + reach.y + slack);
  bounds.upper_z = static_cast<float>(centre.z + reach.z + slack);
}

void closed_form_intersect(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  const WorldObject& object = *static_cast<const ClosedForm*>(arguments->geometryUserPtr)->object;
  const auto& query = *reinterpret_cast<const Query*>(arguments->context);
  const std::optional<SurfaceHit> found =
      intersect_closed_form(object.shape, into_frame(object.pose, *query.ray));
  RTCRayHit& ray = *reinterpret_cast<RTCRayHit*>(arguments->rayhit);
  if (!found || !(found->range_m < ray.ray.tfar)) return;
  ray.ray.tfar = static_cast<float>(found->range_m);
  ray.hit.geomID = arguments->geomID;
  ray.hit.primID = arguments->primID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

std::array<float, 12> row_major_matrix(const Pose& pose, Vec3 origin_m) {
  const Vec3 x = rotate(pose.rotation, {1, 0, 0});
  const Vec3 y = rotate(pose.rotation, {0, 1, 0});
  const Vec3 z = rotate(pose.rotation, {0, 0, 1});
  const Vec3 p = pose.position_m - origin_m;
  const auto f = [](double v) { return static_cast<float>(v); };
  return {f(x.x), f(y.x), f(z.x), f(p.x), f(x.y), f(y.y),
          f(z.y), f(p.y), f(x.z), f(y.z), f(z.z), f(p.z)};
}

Vec3 as_vec3(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

// Weights of a hit's three corners.
std::array<double, 3> corner_weights(const RTCRayHit& found) {
  const double u = found.hit.u;
  const double v = found.hit.v;
  return {1 - u - v, u, v};
}

// Range and normal on the triangle that Embree named, in double. Embree's own range where the ray
// lies in the triangle's plane and the quotient says nothing.
SurfaceHit on_triangle(const Mesh& mesh, const RTCRayHit& found, const Ray& local) {
  const auto& corner = mesh.triangles[found.hit.primID];
  const Vec3 a = as_vec3(mesh.vertices[corner[0]]);
  const Vec3 b = as_vec3(mesh.vertices[corner[1]]);
  const Vec3 c = as_vec3(mesh.vertices[corner[2]]);
  const Vec3 normal = cross(b - a, c - a);
  const double embree_range = found.ray.tfar;
  const double range = dot(a - local.origin_m, normal) / dot(local.direction, normal);
  const bool sound = std::abs(range - embree_range) < 0.01 * embree_range + 1e-3;
  SurfaceHit hit{sound ? range : embree_range, normalized(normal)};
  if (!mesh.normals.empty()) {
    const std::array<double, 3> weight = corner_weights(found);
    const Vec3 smooth = weight[0] * as_vec3(mesh.normals[corner[0]]) +
                        weight[1] * as_vec3(mesh.normals[corner[1]]) +
                        weight[2] * as_vec3(mesh.normals[corner[2]]);
    // Missing normals, or ones that cancel, say nothing: the face's own stays.
    if (length(smooth) > 1e-6) hit.normal = normalized(smooth);
  }
  return hit;
}

float reflectivity_on_triangle(const Mesh& mesh, const RTCRayHit& found) {
  if (mesh.reflectivity.empty()) return 1;
  const auto& corner = mesh.triangles[found.hit.primID];
  const std::array<double, 3> weight = corner_weights(found);
  double factor = 0;
  for (int i = 0; i < 3; ++i) factor += weight[i] * mesh.reflectivity[corner[i]];
  return static_cast<float>(factor);
}

Hit hit_of(const SurfaceHit& surface, const Ray& local, const WorldObject& object) {
  Hit hit;
  hit.range_m = surface.range_m;
  // In this order a NaN stays one, for surface_scatterers to leave out.
  hit.cos_incidence =
      static_cast<float>(std::min(std::abs(dot(local.direction, surface.normal)), 1.0));
  hit.instance = object.instance;
  hit.normal = rotate(object.pose.rotation, surface.normal);
  return hit;
}

}  // namespace

struct Tracer::Impl {
  // Embree computes in float: at map coordinates (a northing of 4.5e6 m) its steps are half a
  // metre. So it sees everything from the first object.
  Vec3 origin_m;
  std::vector<std::unique_ptr<ClosedForm>> closed_forms;
  RTCDevice device = nullptr;
  RTCScene top = nullptr;
  std::vector<RTCScene> mesh_scenes;
  std::vector<const WorldObject*> planes;       // without end: outside any box
  std::vector<const WorldObject*> by_geometry;  // object of each geometry of `top`

  ~Impl() {
    if (top != nullptr) rtcReleaseScene(top);
    for (RTCScene scene : mesh_scenes) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }

  RTCScene new_scene() const {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    return scene;
  }
  void commit(RTCScene scene) const;
  void add_mesh(const WorldObject& object, const Mesh& mesh);
  void add_closed_form(const WorldObject& object);
  void attach(RTCGeometry geometry, const WorldObject& object);
  Hit refine(const RTCRayHit& found, const Ray& ray) const;
};

// One thread: the order in which several would sort triangles into leaves decides which of two
// triangles owns their common edge.
void Tracer::Impl::commit(RTCScene scene) const {
  Workers(1).for_each(1, [&](std::size_t) { rtcCommitScene(scene); });
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE) {
    throw DeviceFailure("Embree could not build its scene: not enough memory?");
  }
}

void Tracer::Impl::attach(RTCGeometry geometry, const WorldObject& object) {
  rtcCommitGeometry(geometry);
  const unsigned id = rtcAttachGeometry(top, geometry);
  rtcReleaseGeometry(geometry);
  if (by_geometry.size() <= id) by_geometry.resize(id + 1);
  by_geometry[id] = &object;
}

void Tracer::Impl::add_mesh(const WorldObject& object, const Mesh& mesh) {
  RTCScene scene = new_scene();
  mesh_scenes.push_back(scene);
  RTCGeometry triangles = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<std::array<float, 3>*>(
      rtcSetNewGeometryBuffer(triangles, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                              3 * sizeof(float), mesh.vertices.size()));
  auto* indices = static_cast<std::array<std::uint32_t, 3>*>(
      rtcSetNewGeometryBuffer(triangles, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), mesh.triangles.size()));
  if (vertices == nullptr || indices == nullptr) throw std::bad_alloc();
  std::copy(mesh.vertices.begin(), mesh.vertices.end(), vertices);
  std::copy(mesh.triangles.begin(), mesh.triangles.end(), indices);
  rtcCommitGeometry(triangles);
  rtcAttachGeometry(scene, triangles);
  rtcReleaseGeometry(triangles);
  commit(scene);

  RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, scene);
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                          row_major_matrix(object.pose, origin_m).data());
  attach(instance, object);
}

void Tracer::Impl::add_closed_form(const WorldObject& object) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  closed_forms.push_back(std::make_unique<ClosedForm>(ClosedForm{&object, origin_m}));
  rtcSetGeometryUserData(geometry, closed_forms.back().get());
  rtcSetGeometryBoundsFunction(geometry, closed_form_bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, closed_form_intersect);
  attach(geometry, object);
}

Tracer::Tracer(const World& world) : impl_(std::make_unique<Impl>()) {
  if (!world.objects.empty()) impl_->origin_m = world.objects.front().pose.position_m;
  // Embree builds its scenes on TBB's threads unless it is kept to the caller's.
  impl_->device = rtcNewDevice(workers_are_tbb() ? nullptr : "threads=1");
  if (impl_->device == nullptr) throw DeviceFailure("Embree could not start");
  impl_->top = impl_->new_scene();
  for (const WorldObject& object : world.objects) {
    if (const auto* mesh = std::get_if<MeshShape>(&object.shape)) {
      impl_->add_mesh(object, *mesh->mesh);
    } else if (std::holds_alternative<PlaneShape>(object.shape)) {
      impl_->planes.push_back(&object);
    } else {
      impl_->add_closed_form(object);
    }
  }
  impl_->commit(impl_->top);
}

Tracer::~Tracer() = default;

Hit Tracer::Impl::refine(const RTCRayHit& found, const Ray& ray) const {
  const bool instanced = found.hit.instID[0] != RTC_INVALID_GEOMETRY_ID;
  const WorldObject& object = *by_geometry[instanced ? found.hit.instID[0] : found.hit.geomID];
  const Ray local = into_frame(object.pose, ray);
  if (instanced) {
    const Mesh& mesh = *std::get<MeshShape>(object.shape).mesh;
    Hit hit = hit_of(on_triangle(mesh, found, local), local, object);
    hit.reflectivity = reflectivity_on_triangle(mesh, found);
    return hit;
  }
  const std::optional<SurfaceHit> surface = intersect_closed_form(object.shape, local);
  return surface ? hit_of(*surface, local, object) : Hit{};
}

Hit Tracer::first_hit(const Ray& ray, double range_max_m) const {
  RTCRayHit found{};
  const Vec3 from = ray.origin_m - impl_->origin_m;
  found.ray.org_x = static_cast<float>(from.x);
  found.ray.org_y = static_cast<float>(from.y);
  found.ray.org_z = static_cast<float>(from.z);
  found.ray.dir_x = static_cast<float>(ray.direction.x);
  found.ray.dir_y = static_cast<float>(ray.direction.y);
  found.ray.dir_z = static_cast<float>(ray.direction.z);
  found.ray.tnear = static_cast<float>(kNearestHit_m);
  found.ray.tfar = static_cast<float>(range_max_m) * 1.000001f;
  found.ray.mask = ~0u;
  found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  found.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  Query query;
  init_context(query.context);
  query.ray = &ray;
  intersect_one(impl_->top, query.context, found);

  Hit nearest;
  if (found.hit.geomID != RTC_INVALID_GEOMETRY_ID) nearest = impl_->refine(found, ray);
  for (const WorldObject* plane : impl_->planes) {
    const Ray local = into_frame(plane->pose, ray);
    const auto hit = intersect_closed_form(plane->shape, local);
    if (!hit || (nearest.instance != 0 && hit->range_m >= nearest.range_m)) continue;
    nearest = hit_of(*hit, local, *plane);
  }
  return nearest.range_m <= range_max_m ? nearest : Hit{};
}

std::vector<Hit> Tracer::trace_fan(const Fan& fan, const Pose& pose, double range_max_m,
                                   const Workers& workers) const {
  std::vector<Hit> hits(fan.size());
  workers.for_each(fan.beams, [&](std::size_t beam) {
    for (int a = 0; a < fan.rays_azimuth; ++a) {
      const double azimuth = fan.azimuth_rad[beam * fan.rays_azimuth + a];
      for (int e = 0; e < fan.rays_elevation; ++e) {
        const Vec3 direction = unit_vector(azimuth, fan.elevation_rad[e]);
        hits[ray_index(fan, static_cast<int>(beam), a, e)] =
            first_hit({pose.position_m, normalized(rotate(pose.rotation, direction))}, range_max_m);
      }
    }
  });
  return hits;
}

std::string Tracer::instruction_set() const {
  if (rtcGetDeviceProperty(impl_->device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0) {
    return "avx512";
  }
  if (rtcGetDeviceProperty(impl_->device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0) {
    return "avx2";
  }
  return "sse";
}

}  // namespace ensonify
