#include "trace/packets.h"

#include <algorithm>
#include <array>

#include "trace/refine.h"
#include "trace/strip.h"

namespace ensonify {
namespace {

// What Embree says of a tile's rays, and what is made of it.
struct TileHits {
  std::array<Found, kMostRays> found;
  std::array<Hit, kMostRays> hits;
};

template <class RayHits>
void refine_packet(const Scene& scene, const Strip<RayHits>& strip, int count, double range_max_m,
                   TileHits& tile) {
  const auto& hit = strip.packet.hit;
  for (int i = 0; i < count; ++i) {
    tile.found[i] = {hit.geomID[i], hit.instID[0][i], hit.primID[i], strip.packet.ray.tfar[i],
                     hit.u[i],      hit.v[i]};
  }
  refine(scene, strip.query, std::span(tile.found).first(count), range_max_m, tile.hits.data());
}

template <class RayHits>
void trace_tile(const FanRays& rays, int first_elevation, Strip<RayHits>& strip, TileHits& tile,
                std::vector<Hit>& hits) {
  const int elevations = std::min(rays.tile.elevations, rays.fan.rays_elevation - first_elevation);
  aim(rays, first_elevation, elevations, strip);
  intersect_packet(rays.scene.top, strip.query.context, strip.valid.data(), strip.packet);
  const int count = strip.columns * elevations;
  refine_packet(rays.scene, strip, count, rays.range_max_m, tile);
  for (int c = 0; c < strip.columns; ++c) {
    std::copy_n(
        tile.hits.begin() + c * elevations, elevations,
        hits.begin() + (strip.first_column + c) * rays.fan.rays_elevation + first_elevation);
  }
}

template <class RayHits>
std::vector<Hit> trace_in_packets(const Scene& scene, const Fan& fan, const Pose& pose,
                                  double range_max_m, const Workers& workers) {
  const FanRays rays = fan_rays(scene, fan, pose, range_max_m, Strip<RayHits>::kRays);
  std::vector<Hit> hits(fan.size());
  workers.for_each(rays.strips(), [&](std::size_t i) {
    Strip<RayHits> strip;
    TileHits tile;
    init_strip(rays, i, strip);
    for (int e = 0; e < fan.rays_elevation; e += rays.tile.elevations) {
      trace_tile(rays, e, strip, tile, hits);
    }
  });
  return hits;
}

template <class RayHits>
void trace_bundle(const Scene& scene, Vec3 origin_m, std::span<const Vec3> directions,
                  double range_max_m, std::span<Hit> hits) {
  constexpr std::size_t kRays = Strip<RayHits>::kRays;
  const LocalOrigins origins = local_origins(scene, origin_m);
  Strip<RayHits> strip;
  TileHits tile;
  start_at(scene, origin_m, origins, strip);
  for (std::size_t first = 0; first < directions.size(); first += kRays) {
    const std::size_t count = std::min(kRays, directions.size() - first);
    for (std::size_t i = 0; i < kRays; ++i) {
      const Vec3 d = directions[first + std::min(i, count - 1)];
      strip.query.directions.x[i] = d.x;
      strip.query.directions.y[i] = d.y;
      strip.query.directions.z[i] = d.z;
    }
    load(strip, static_cast<int>(count), range_max_m);
    intersect_packet(scene.top, strip.query.context, strip.valid.data(), strip.packet);
    refine_packet(scene, strip, static_cast<int>(count), range_max_m, tile);
    std::copy_n(tile.hits.begin(), count, hits.begin() + first);
  }
}

}  // namespace

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

FanRays fan_rays(const Scene& scene, const Fan& fan, const Pose& pose, double range_max_m,
                 int rays) {
  FanRays all{
      scene, fan, pose, range_max_m, tile_of(fan, rays), local_origins(scene, pose.position_m),
      {},    {}};
  for (const double elevation : fan.elevation_rad) {
    all.cos_elevation.push_back(std::cos(elevation));
    all.sin_elevation.push_back(std::sin(elevation));
  }
  return all;
}

FanTracer* fan_tracer(int rays) {
  if (rays == 16) return trace_in_packets<RTCRayHit16>;
  return rays == 8 ? trace_in_packets<RTCRayHit8> : trace_in_packets<RTCRayHit4>;
}

BundleTracer* bundle_tracer(int rays) {
  if (rays == 16) return trace_bundle<RTCRayHit16>;
  return rays == 8 ? trace_bundle<RTCRayHit8> : trace_bundle<RTCRayHit4>;
}

int packet_rays(const Scene& scene) {
  const auto takes = [&](RTCDeviceProperty property) {
    return rtcGetDeviceProperty(scene.meshes->device, property) != 0;
  };
  if (takes(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
  return takes(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) ? 8 : 4;
}

}  // namespace ensonify
