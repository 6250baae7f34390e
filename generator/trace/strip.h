// How a fan is cut into packets of rays: tiles of neighboring columns and elevations. Private to
// packets.cpp.
//
//   Tile     tile_of
//   FanRays  fan_rays   what all tiles of a fan share
//   Strip    init_strip aim   columns as wide as a tile, and a packet that moves along them
//   start_at  turn  load      a packet of any rays from one point
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "trace/scene.h"

namespace ensonify {

// Columns and elevations of a packet.
struct Tile {
  int columns = 1, elevations = 1;
};

// The tile of a packet, about four times as wide as high if the fan allows it: where rays meet a
// floor at a small grazing angle, neighbors in azimuth have about the same range, but neighbors in
// elevation do not.
inline Tile tile_of(const Fan& fan, int rays) {
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

struct FanRays {
  const Scene& scene;
  const Fan& fan;
  const Pose& pose;
  double range_max_m = 0;
  Tile tile;
  LocalOrigins origins;
  std::vector<double> cos_elevation, sin_elevation;

  std::size_t strips() const {
    const auto breadth = static_cast<std::size_t>(tile.columns);
    return (fan.azimuth_rad.size() + breadth - 1) / breadth;
  }
};

inline FanRays fan_rays(const Scene& scene, const Fan& fan, const Pose& pose, double range_max_m,
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
};

// All rays of the packet start at origin_m; `origins` is the same point in all frames.
template <class RayHits>
void start_at(const Scene& scene, Vec3 origin_m, const LocalOrigins& origins,
              Strip<RayHits>& strip) {
  init_context(strip.query.context);
  strip.query.origin_m = origin_m;
  strip.query.origins = &origins;
  strip.query.closed_form = strip.closed_form.data();
  const Vec3 from = origin_m - scene.origin_m;
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

// The strip of that number, from 0.
template <class RayHits>
void init_strip(const FanRays& rays, std::size_t number, Strip<RayHits>& strip) {
  strip.first_column = number * static_cast<std::size_t>(rays.tile.columns);
  strip.columns = static_cast<int>(std::min(rays.fan.azimuth_rad.size() - strip.first_column,
                                            static_cast<std::size_t>(rays.tile.columns)));
  for (int c = 0; c < strip.columns; ++c) {
    strip.cos_azimuth[c] = std::cos(rays.fan.azimuth_rad[strip.first_column + c]);
    strip.sin_azimuth[c] = std::sin(rays.fan.azimuth_rad[strip.first_column + c]);
  }
  start_at(rays.scene, rays.pose.position_m, rays.origins, strip);
}

// Turns the first directions by a rotation and scales them to unit length.
void turn(Quat rotation, int count, Directions& directions);

// Loads the query's directions into the packet. Only the first `count` lanes are active; the others
// must hold valid directions.
template <class RayHits>
void load(Strip<RayHits>& strip, int count, double range_max_m) {
  const Directions& to = strip.query.directions;
  auto& ray = strip.packet.ray;
  auto& hit = strip.packet.hit;
  const float far = float_range(range_max_m);
  for (int i = 0; i < strip.kRays; ++i) {
    ray.dir_x[i] = static_cast<float>(to.x[i]);
    ray.dir_y[i] = static_cast<float>(to.y[i]);
    ray.dir_z[i] = static_cast<float>(to.z[i]);
    ray.tfar[i] = far;
    hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    strip.valid[i] = i < count ? -1 : 0;
  }
}

// Aims the packet at a tile, column by column. Inactive lanes repeat the last ray.
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
  for (int i = 0; i < kRays; ++i) {
    to.x[i] = cos_el[i] * cos_az[i];
    to.y[i] = cos_el[i] * sin_az[i];
    to.z[i] = sin_el[i];
  }
  turn(rays.pose.rotation, kRays, to);
  load(strip, count, rays.range_max_m);
}

}  // namespace ensonify
