#include "trace/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <utility>

#include "core/error.h"

namespace ensonify {
namespace {

void closed_form_bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& form = *static_cast<const ClosedForm*>(arguments->geometryUserPtr);
  const Shape& shape = form.placed.object->shape;
  const Pose& pose = form.placed.pose;
  Vec3 half{};
  if (const auto* box = std::get_if<BoxShape>(&shape)) half = half_extents(*box);
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) half = half_extents(*sphere);
  if (const auto* cyl = std::get_if<CylinderShape>(&shape)) half = half_extents(*cyl);
  const Vec3 x = rotate(pose.rotation, {half.x, 0, 0});
  const Vec3 y = rotate(pose.rotation, {0, half.y, 0});
  const Vec3 z = rotate(pose.rotation, {0, 0, half.z});
  const Vec3 reach{std::abs(x.x) + std::abs(y.x) + std::abs(z.x),
                   std::abs(x.y) + std::abs(y.y) + std::abs(z.y),
                   std::abs(x.z) + std::abs(y.z) + std::abs(z.z)};
  const Vec3 centre = pose.position_m - form.scene->origin_m;
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

RTCScene new_scene(RTCDevice device) {
  RTCScene made = rtcNewScene(device);
  if (made == nullptr) throw DeviceFailure("Embree could not make a scene: not enough memory?");
  rtcSetSceneFlags(made, RTC_SCENE_FLAG_ROBUST);
  return made;
}

// One thread: the order in which several would sort triangles into leaves decides which of two
// triangles owns their common edge.
void commit(RTCDevice device, RTCScene part) {
  Workers(1).for_each(1, [&](std::size_t) { rtcCommitScene(part); });
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE) {
    throw DeviceFailure("Embree could not build its scene: not enough memory?");
  }
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
  // Embree builds its scenes on TBB's threads unless it is kept to the caller's.
  meshes->device = rtcNewDevice(workers_are_tbb() ? nullptr : "threads=1");
  if (meshes->device == nullptr) throw DeviceFailure("Embree could not start");
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
