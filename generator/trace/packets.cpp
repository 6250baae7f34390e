#include "trace/packets.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "trace/refine.h"

namespace ensonify {
namespace {

// Columns and elevations of a packet.
struct Tile {
  int columns = 1, elevations = 1;
};

// Neighbours in azimuth are at about the same range also where a floor is met at a small angle,
// neighbours in elevation are not: four times as wide as high, as far as the fan goes.
Tile tile_of(const Fan& fan, int rays) {
  constexpr double kAspect = 4;
  const std::vector<double>&az = fan.azimuth_rad, &el = fan.elevation_rad;
  const double azimuth_step = az.size() > 1 ? az[1] - az[0] : 0;
  const double elevation_step = el.size() > 1 ? el[1] - el[0] : 0;
  const auto too_wide = [&](int columns, int elevations) {
    if (static_cast<std::size_t>(columns) / 2 >= az.size()) return true;
    return static_cast<std::size_t>(elevations) < el.size() &&
           columns / 2 * azimuth_step >= kAspect * 2 * elevations * elevation_step;
  };
  Tile tile{rays, 1};
  while (tile.columns > 1 && too_wide(tile.columns, tile.elevations)) {
    tile = {tile.columns / 2, tile.elevations * 2};
  }
  return tile;
}

// What all tiles of a fan share.
struct FanRays {
  const Scene& scene;
  const Fan& fan;
  const Pose& pose;
  double range_max_m = 0;
  Tile tile;
  LocalOrigins origins;
  std::vector<double> cos_elevation, sin_elevation;
};

// The columns of a tile's breadth, and a packet to go through them.
template <class RayHits>
struct Strip {
  static constexpr int kRays = sizeof(RayHits::ray.tfar) / sizeof(float);

  alignas(64) RayHits packet;
  alignas(64) std::array<int, kRays> valid;
  std::size_t first_column = 0;
  int columns = 0;
  std::array<double, kRays> cos_azimuth, sin_azimuth;
  Query query;
  std::array<ClosedFormHit, kRays> closed_form;
  std::array<Found, kRays> found;
  std::array<Hit, kRays> hits;
};

template <class RayHits>
void init_strip(const FanRays& rays, std::size_t first_column, Strip<RayHits>& strip) {
  strip.first_column = first_column;
  strip.columns = static_cast<int>(std::min(rays.fan.azimuth_rad.size() - first_column,
                                            static_cast<std::size_t>(rays.tile.columns)));
  for (int c = 0; c < strip.columns; ++c) {
    strip.cos_azimuth[c] = std::cos(rays.fan.azimuth_rad[first_column + c]);
    strip.sin_azimuth[c] = std::sin(rays.fan.azimuth_rad[first_column + c]);
  }
  init_context(strip.query.context);
  strip.query.origin_m = rays.pose.position_m;
  strip.query.origins = &rays.origins;
  strip.query.closed_form = strip.closed_form.data();
  const Vec3 from = rays.pose.position_m - rays.scene.origin_m;
  auto& ray = strip.packet.ray;
  for (int i = 0; i < strip.kRays; ++i) {
    ray.org_x[i] = static_cast<float>(from.x);
    ray.org_y[i] = static_cast<float>(from.y);
    ray.org_z[i] = static_cast<float>(from.z);
    ray.tnear[i] = static_cast<float>(kNearestHit_m);
    ray.time[i] = 0;
    ray.mask[i] = ~0u;
    ray.id[i] = static_cast<unsigned>(i);
    ray.flags[i] = 0;
  }
}

// Aims the packet at a tile, column by column. Lanes without a ray go along with the last one.
template <class RayHits>
void aim(const FanRays& rays, int first_elevation, int elevations, Strip<RayHits>& strip) {
  constexpr int kRays = Strip<RayHits>::kRays;
  const int count = strip.columns * elevations;
  alignas(64) std::array<double, kRays> cos_az, sin_az, cos_el, sin_el;
  for (int i = 0; i < kRays; ++i) {
    const int lane = std::min(i, count - 1);
    const int c = lane / elevations, e = first_elevation + lane % elevations;
    cos_az[i] = strip.cos_azimuth[c];
    sin_az[i] = strip.sin_azimuth[c];
    cos_el[i] = rays.cos_elevation[e];
    sin_el[i] = rays.sin_elevation[e];
  }
  Directions& to = strip.query.directions;
  const Quat rotation = rays.pose.rotation;
  for (int i = 0; i < kRays; ++i) {
    const Vec3 d =
        normalized(rotate(rotation, {cos_el[i] * cos_az[i], cos_el[i] * sin_az[i], sin_el[i]}));
    to.x[i] = d.x;
    to.y[i] = d.y;
    to.z[i] = d.z;
  }
  auto& ray = strip.packet.ray;
  auto& hit = strip.packet.hit;
  const float far = static_cast<float>(rays.range_max_m) * 1.000001f;
  for (int i = 0; i < kRays; ++i) {
    ray.dir_x[i] = static_cast<float>(to.x[i]);
    ray.dir_y[i] = static_cast<float>(to.y[i]);
    ray.dir_z[i] = static_cast<float>(to.z[i]);
    ray.tfar[i] = far;
    hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    strip.valid[i] = i < count ? -1 : 0;
  }
}

template <class RayHits>
void trace_tile(const FanRays& rays, int first_elevation, Strip<RayHits>& strip,
                std::vector<Hit>& hits) {
  const int elevations = std::min(rays.tile.elevations, rays.fan.rays_elevation - first_elevation);
  aim(rays, first_elevation, elevations, strip);
  intersect_packet(rays.scene.top, strip.query.context, strip.valid.data(), strip.packet);
  const auto& hit = strip.packet.hit;
  const int count = strip.columns * elevations;
  for (int i = 0; i < count; ++i) {
    strip.found[i] = {hit.geomID[i], hit.instID[0][i], hit.primID[i], strip.packet.ray.tfar[i],
                      hit.u[i],      hit.v[i]};
  }
  refine(rays.scene, strip.query, std::span(strip.found).first(count), rays.range_max_m,
         strip.hits.data());
  for (int c = 0; c < strip.columns; ++c) {
    std::copy_n(
        strip.hits.begin() + c * elevations, elevations,
        hits.begin() + (strip.first_column + c) * rays.fan.rays_elevation + first_elevation);
  }
}

template <class RayHits>
std::vector<Hit> trace_in_packets(const Scene& scene, const Fan& fan, const Pose& pose,
                                  double range_max_m, const Workers& workers) {
  FanRays rays{scene,
               fan,
               pose,
               range_max_m,
               tile_of(fan, Strip<RayHits>::kRays),
               local_origins(scene, pose.position_m),
               {},
               {}};
  for (const double elevation : fan.elevation_rad) {
    rays.cos_elevation.push_back(std::cos(elevation));
    rays.sin_elevation.push_back(std::sin(elevation));
  }
  std::vector<Hit> hits(fan.size());
  const auto breadth = static_cast<std::size_t>(rays.tile.columns);
  workers.for_each((fan.azimuth_rad.size() + breadth - 1) / breadth, [&](std::size_t i) {
    Strip<RayHits> strip;
    init_strip(rays, i * breadth, strip);
    for (int e = 0; e < fan.rays_elevation; e += rays.tile.elevations) {
      trace_tile(rays, e, strip, hits);
    }
  });
  return hits;
}

}  // namespace

FanTracer* fan_tracer(int rays) {
  if (rays == 16) return trace_in_packets<RTCRayHit16>;
  return rays == 8 ? trace_in_packets<RTCRayHit8> : trace_in_packets<RTCRayHit4>;
}

int packet_rays(const Scene& scene) {
  const auto takes = [&](RTCDeviceProperty property) {
    return rtcGetDeviceProperty(scene.meshes->device, property) != 0;
  };
  if (takes(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
  return takes(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) ? 8 : 4;
}

}  // namespace ensonify
