#include "trace/tracer.h"

#include <algorithm>
#include <utility>

#include "trace/packets.h"
#include "trace/refine.h"

namespace ensonify {

namespace {

bool same(const Pose& a, const Pose& b) {
  return a.position_m == b.position_m && a.rotation == b.rotation;
}

}  // namespace

struct Tracer::Impl {
  const World& world;
  std::vector<Pose> object_in_world;
  Scene scene;
  FanTracer* trace_fan = nullptr;

  Impl(const World& w, std::vector<Pose> poses, std::shared_ptr<const MeshHierarchies> meshes)
      : world(w), object_in_world(std::move(poses)) {
    build_scene(world, object_in_world, std::move(meshes), scene);
    trace_fan = fan_tracer(packet_rays(scene));
  }
};

Tracer::Tracer(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

Tracer::Tracer(const World& world)
    : impl_(std::make_shared<const Impl>(world, own_poses(world), build_hierarchies(world))) {}

Tracer Tracer::at(std::span<const Pose> object_in_world) const {
  if (std::ranges::equal(object_in_world, impl_->object_in_world, same)) return *this;
  return Tracer(std::make_shared<const Impl>(
      impl_->world, std::vector(object_in_world.begin(), object_in_world.end()),
      impl_->scene.meshes));
}

Hit Tracer::first_hit(const Ray& ray, double range_max_m) const {
  const Scene& scene = impl_->scene;
  ClosedFormHit closed_form;
  Query query;
  query.closed_form = &closed_form;
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
  rays.ray.tfar = static_cast<float>(range_max_m) * 1.000001f;
  rays.ray.mask = ~0u;
  rays.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rays.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  intersect_one(scene.top, query.context, rays);
  const Found found{rays.hit.geomID, rays.hit.instID[0], rays.hit.primID,
                    rays.ray.tfar,   rays.hit.u,         rays.hit.v};
  Hit hit;
  refine(scene, query, {&found, 1}, range_max_m, &hit);
  return hit;
}

std::vector<Hit> Tracer::trace_fan(const Fan& fan, const Pose& pose, double range_max_m,
                                   const Workers& workers) const {
  return impl_->trace_fan(impl_->scene, fan, pose, range_max_m, workers);
}

std::string Tracer::instruction_set() const {
  RTCDevice device = impl_->scene.meshes->device;
  if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0) {
    return "avx512";
  }
  if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0) {
    return "avx2";
  }
  return "sse";
}

}  // namespace ensonify
