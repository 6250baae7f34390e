#include "trace/tracer.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "acoustics/scattering.h"
#include "core/compile_targets.h"
#include "core/front_planes.h"
#include "trace/packets.h"
#include "trace/refine.h"

namespace ensonify {
namespace {

bool same(const Pose& a, const Pose& b) {
  return a.position_m == b.position_m && a.rotation == b.rotation;
}

}  // namespace

Fan make_fan(const Sonar& sonar) {
  Fan fan{sonar.beam_count,        sonar.rays_azimuth,        sonar.rays_elevation,
          ray_azimuths_rad(sonar), ray_elevations_rad(sonar), {}};
  const double azimuth_step = sonar.beam_spacing_rad / sonar.rays_azimuth;
  if (!sonar.azimuth_rad.empty()) {
    for (int j = 0; j < sonar.beam_count; ++j) {
      fan.relative_width.push_back(cell_width_rad(sonar, j) / sonar.beam_spacing_rad);
    }
  }
  const double elevation_step = sonar.elevation_fan_rad / sonar.rays_elevation;
  for (int e = 0; e < sonar.rays_elevation; ++e) {
    const double low = -sonar.elevation_fan_rad / 2 + e * elevation_step;
    fan.solid_angle_sr.push_back(cell_solid_angle_sr(azimuth_step, low, low + elevation_step));
  }
  return fan;
}

Fan fan_of_group(const Fan& fan, int first, int step, int count) {
  Fan part{count,
           fan.rays_azimuth,
           fan.rays_elevation,
           {},
           fan.elevation_rad,
           fan.solid_angle_sr,
           {},
           first,
           step,
           true};
  for (int k = 0; k < part.beams; ++k) {
    const auto column =
        fan.azimuth_rad.begin() + part.beam_of(k) * std::ptrdiff_t{fan.rays_azimuth};
    part.azimuth_rad.insert(part.azimuth_rad.end(), column, column + fan.rays_azimuth);
    if (!fan.relative_width.empty()) {
      part.relative_width.push_back(fan.relative_width_of(part.beam_of(k)));
    }
  }
  return part;
}

struct Tracer::Impl {
  const World& world;
  std::vector<Pose> object_in_world;
  Scene scene;
  FanTracer* trace_fan = nullptr;
  BundleTracer* trace_bundle = nullptr;
  // Built at first use, because not every data set needs the hits behind others.
  mutable std::once_flag along_once;
  mutable AlongScene along_scene;

  const AlongScene& along() const {
    std::call_once(along_once, [this] { build_along_scene(scene, along_scene); });
    return along_scene;
  }

  Impl(const World& w, std::vector<Pose> poses, std::shared_ptr<const MeshHierarchies> meshes)
      : world(w), object_in_world(std::move(poses)) {
    build_scene(world, object_in_world, std::move(meshes), scene);
    trace_fan = fan_tracer(packet_rays(scene));
    trace_bundle = bundle_tracer(packet_rays(scene));
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
  RTCRayHit rays = one_ray(scene, ray, range_max_m, query);
  intersect_one(scene.top, query.context, rays);
  const Found found{rays.hit.geomID, rays.hit.instID[0], rays.hit.primID,
                    rays.ray.tfar,   rays.hit.u,         rays.hit.v};
  Hit hit;
  refine(scene, query, {&found, 1}, range_max_m, &hit);
  return hit;
}

void Tracer::first_hits(Vec3 origin_m, std::span<const Vec3> directions, double range_max_m,
                        std::span<Hit> hits) const {
  impl_->trace_bundle(impl_->scene, origin_m, nullptr, directions, range_max_m, hits, {});
}

void Tracer::first_hits(const Pose& pose, std::span<const Vec3> directions, double range_max_m,
                        std::span<Hit> hits, std::span<VertexColor> colors) const {
  impl_->trace_bundle(impl_->scene, pose.position_m, &pose.rotation, directions, range_max_m, hits,
                      colors);
}

std::vector<Hit> Tracer::trace_fan(const Fan& fan, const Pose& pose, double range_max_m,
                                   const Workers& workers) const {
  return impl_->trace_fan(impl_->scene, fan, pose, range_max_m, workers);
}

std::vector<Hit> Tracer::hits_along(const Ray& ray, double range_max_m) const {
  return ensonify::hits_along(impl_->along(), ray, range_max_m);
}

HitsBehind Tracer::trace_behind(const Fan& fan, std::span<const Hit> hits, const Pose& pose,
                                double range_max_m, const Workers& workers) const {
  return ensonify::trace_behind(impl_->along(), fan, hits, pose, range_max_m, workers);
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
