#include "trace/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"

namespace ensonify {
namespace {

// A box in the object's frame; that of a mesh need not be centered on the origin.
struct LocalBox {
  Vec3 centre, half;
};

LocalBox box_of(const Scene& scene, const Shape& shape) {
  if (const auto* box = std::get_if<BoxShape>(&shape)) return {{}, half_extents(*box)};
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return {{}, half_extents(*sphere)};
  if (const auto* cyl = std::get_if<CylinderShape>(&shape)) return {{}, half_extents(*cyl)};
  const auto* mesh = std::get_if<MeshShape>(&shape);
  if (mesh == nullptr) return {};
  RTCBounds b;
  rtcGetSceneBounds(scene.meshes->scenes.at(mesh->mesh.get()), &b);
  const Vec3 low{b.lower_x, b.lower_y, b.lower_z}, high{b.upper_x, b.upper_y, b.upper_z};
  return {0.5 * (low + high), 0.5 * (high - low)};
}

void closed_form_bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& form = *static_cast<const ClosedForm*>(arguments->geometryUserPtr);
  *arguments->bounds_o = bounds_of(*form.scene, form.placed);
}

void closed_form_intersect(const RTCIntersectFunctionNArguments* arguments) {
  const auto& form = *static_cast<const ClosedForm*>(arguments->geometryUserPtr);
  auto& query = *reinterpret_cast<Query*>(arguments->context);
  const unsigned count = arguments->N;
  RTCRayN* rays = RTCRayHitN_RayN(arguments->rayhit, count);
  RTCHitN* hits = RTCRayHitN_HitN(arguments->rayhit, count);
  for (unsigned lane = 0; lane < count; ++lane) {
    if (arguments->valid[lane] == 0) continue;
    const unsigned ray = RTCRayN_id(rays, count, lane);
    const Ray local = local_ray(*form.scene, query, ray, arguments->geomID);
    const std::optional<SurfaceHit> found = intersect_closed_form(form.placed.object->shape, local);
    float& nearest = RTCRayN_tfar(rays, count, lane);
    if (!found || !(found->range_m < nearest)) continue;
    nearest = static_cast<float>(found->range_m);
    RTCHitN_geomID(hits, count, lane) = arguments->geomID;
    RTCHitN_primID(hits, count, lane) = arguments->primID;
    RTCHitN_instID(hits, count, lane, 0) = RTC_INVALID_GEOMETRY_ID;
    query.closed_form[ray] = {*found, local.direction};
  }
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

void build_mesh(RTCDevice device, const Mesh& mesh, RTCScene own) {
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
  rtcAttachGeometry(own, triangles);
  rtcReleaseGeometry(triangles);
  commit(device, own);
}

void attach(Scene& scene, RTCGeometry geometry, const PlacedObject& placed) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene.top, geometry, static_cast<unsigned>(scene.by_geometry.size()));
  rtcReleaseGeometry(geometry);
  scene.by_geometry.push_back(placed);
}

void add_mesh(Scene& scene, const PlacedObject& placed, const Mesh& mesh) {
  RTCGeometry instance = rtcNewGeometry(scene.meshes->device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, scene.meshes->scenes.at(&mesh));
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                          row_major_matrix(placed.pose, scene.origin_m).data());
  attach(scene, instance, placed);
}

void add_closed_form(Scene& scene, const PlacedObject& placed) {
  RTCGeometry geometry = rtcNewGeometry(scene.meshes->device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  scene.closed_forms.push_back({&scene, placed});
  rtcSetGeometryUserData(geometry, &scene.closed_forms.back());
  rtcSetGeometryBoundsFunction(geometry, closed_form_bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, closed_form_intersect);
  attach(scene, geometry, placed);
}

}  // namespace

RTCBounds bounds_of(const Scene& scene, const PlacedObject& placed) {
  const Pose& pose = placed.pose;
  const auto [middle, half] = box_of(scene, placed.object->shape);
  const Vec3 x = rotate(pose.rotation, {half.x, 0, 0});
  const Vec3 y = rotate(pose.rotation, {0, half.y, 0});
  const Vec3 z = rotate(pose.rotation, {0, 0, half.z});
  const Vec3 reach{std::abs(x.x) + std::abs(y.x) + std::abs(z.x),
                   std::abs(x.y) + std::abs(y.y) + std::abs(z.y),
                   std::abs(x.z) + std::abs(y.z) + std::abs(z.z)};
  const Vec3 centre = transform_point(pose, middle) - scene.origin_m;
  // The slack exceeds float rounding, because objects outside of these boxes are never tested.
  const double slack = 1e-5 + 1e-6 * (length(centre) + length(reach));
  RTCBounds bounds{};
  bounds.lower_x = static_cast<float>(centre.x - reach.x - slack);
  bounds.lower_y = static_cast<float>(centre.y - reach.y - slack);
  bounds.lower_z = static_cast<float>(centre.z - reach.z - slack);
  bounds.upper_x = static_cast<float>(centre.x + reach.x + slack);
  bounds.upper_y = static_cast<float>(centre.y + reach.y + slack);
  bounds.upper_z = static_cast<float>(centre.z + reach.z + slack);
  return bounds;
}

RTCScene new_scene(RTCDevice device) {
  RTCScene made = rtcNewScene(device);
  if (made == nullptr) throw DeviceFailure("Embree cannot create a scene; is there enough memory?");
  rtcSetSceneFlags(made, RTC_SCENE_FLAG_ROBUST);
  return made;
}

// Uses one thread, because several would sort triangles into leaves in a varying order. This order
// decides which of two triangles owns their common edge.
void commit(RTCDevice device, RTCScene part) {
  Workers(1).for_each(1, [&](std::size_t) { rtcCommitScene(part); });
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE) {
    throw DeviceFailure("Embree cannot build its scene; is there enough memory?");
  }
}

MeshHierarchies::~MeshHierarchies() {
  for (const auto& [mesh, scene] : scenes) rtcReleaseScene(scene);
  if (device != nullptr) rtcReleaseDevice(device);
}

Scene::~Scene() {
  if (top != nullptr) rtcReleaseScene(top);
}

std::vector<Pose> own_poses(const World& world) {
  std::vector<Pose> poses;
  for (const WorldObject& object : world.objects) poses.push_back(object.pose);
  return poses;
}

std::shared_ptr<const MeshHierarchies> build_hierarchies(const World& world) {
  auto meshes = std::make_shared<MeshHierarchies>();
  // Embree builds its scenes on TBB's threads unless it is limited to the caller's.
  meshes->device = rtcNewDevice(workers_are_tbb() ? nullptr : "threads=1");
  if (meshes->device == nullptr) throw DeviceFailure("Embree cannot start");
  for (const WorldObject& object : world.objects) {
    const auto* shape = std::get_if<MeshShape>(&object.shape);
    if (shape == nullptr || meshes->scenes.contains(shape->mesh.get())) continue;
    RTCScene& own = meshes->scenes[shape->mesh.get()];
    own = new_scene(meshes->device);
    build_mesh(meshes->device, *shape->mesh, own);
  }
  return meshes;
}

void build_scene(const World& world, std::span<const Pose> object_in_world,
                 std::shared_ptr<const MeshHierarchies> meshes, Scene& scene) {
  ENSONIFY_ASSERT(object_in_world.size() == world.objects.size());
  if (!object_in_world.empty()) scene.origin_m = object_in_world.front().position_m;
  scene.meshes = std::move(meshes);
  scene.top = new_scene(scene.meshes->device);
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const PlacedObject placed{&world.objects[i], object_in_world[i]};
    if (!placed.object->fields.empty()) {
      scene.uneven.resize(std::max<std::size_t>(scene.uneven.size(), placed.object->instance + 1));
      scene.uneven[placed.object->instance] = placed;
    }
    if (const auto* mesh = std::get_if<MeshShape>(&placed.object->shape)) {
      add_mesh(scene, placed, *mesh->mesh);
    } else if (std::holds_alternative<PlaneShape>(placed.object->shape)) {
      scene.planes.push_back(placed);
    } else {
      add_closed_form(scene, placed);
    }
  }
  const std::lock_guard lock(scene.meshes->building);
  commit(scene.meshes->device, scene.top);
}

LocalOrigins local_origins(const Scene& scene, Vec3 origin_m) {
  LocalOrigins origins;
  for (const PlacedObject& placed : scene.by_geometry) {
    origins.geometries_m.push_back(inverse_transform_point(placed.pose, origin_m));
  }
  for (const PlacedObject& plane : scene.planes) {
    origins.planes_m.push_back(inverse_transform_point(plane.pose, origin_m));
  }
  return origins;
}

RTCRayHit one_ray(const Scene& scene, const Ray& ray, double range_max_m, Query& query) {
  init_context(query.context);
  query.origin_m = ray.origin_m;
  query.directions.x[0] = ray.direction.x;
  query.directions.y[0] = ray.direction.y;
  query.directions.z[0] = ray.direction.z;
  RTCRayHit rays{};
  const Vec3 from = ray.origin_m - scene.origin_m;
  rays.ray.org_x = static_cast<float>(from.x);
  rays.ray.org_y = static_cast<float>(from.y);
  rays.ray.org_z = static_cast<float>(from.z);
  rays.ray.dir_x = static_cast<float>(ray.direction.x);
  rays.ray.dir_y = static_cast<float>(ray.direction.y);
  rays.ray.dir_z = static_cast<float>(ray.direction.z);
  rays.ray.tnear = static_cast<float>(kNearestHit_m);
  rays.ray.tfar = float_range(range_max_m);
  rays.ray.mask = ~0u;
  rays.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rays.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return rays;
}

Vec3 local_origin(const Scene& scene, const Query& query, unsigned geometry) {
  if (query.origins != nullptr) return query.origins->geometries_m[geometry];
  return inverse_transform_point(scene.by_geometry[geometry].pose, query.origin_m);
}

Ray local_ray(const Scene& scene, const Query& query, unsigned ray, unsigned geometry) {
  const Quat rotation = scene.by_geometry[geometry].pose.rotation;
  return {local_origin(scene, query, geometry), rotate(conjugate(rotation), query.directions[ray])};
}

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

}  // namespace ensonify
