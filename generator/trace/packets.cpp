#include "trace/packets.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>

#include "core/compile_targets.h"
#include "core/error.h"
#include "trace/refine.h"
#include "trace/strip.h"

namespace ensonify {

ENSONIFY_VECTOR_CLONES void turn(Quat rotation, int count, Directions& directions) {
  for (int i = 0; i < count; ++i) {
    const Vec3 d =
        normalized(rotate(rotation, Vec3{directions.x[i], directions.y[i], directions.z[i]}));
    directions.x[i] = d.x;
    directions.y[i] = d.y;
    directions.z[i] = d.z;
  }
}

namespace {

// Embree's results for the rays of a tile, and the hits computed from them.
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
void trace_bundle(const Scene& scene, Vec3 origin_m, const Quat* rotation,
                  std::span<const Vec3> directions, double range_max_m, std::span<Hit> hits,
                  std::span<VertexColor> colors) {
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
    if (rotation != nullptr) turn(*rotation, strip.kRays, strip.query.directions);
    load(strip, static_cast<int>(count), range_max_m);
    intersect_packet(scene.top, strip.query.context, strip.valid.data(), strip.packet);
    refine_packet(scene, strip, static_cast<int>(count), range_max_m, tile);
    std::copy_n(tile.hits.begin(), count, hits.begin() + first);
    if (colors.empty()) continue;
    for (std::size_t i = 0; i < count; ++i) {
      colors[first + i] = color_of(scene, tile.found[i], tile.hits[i]);
    }
  }
}

bool before(const Hit& a, const Hit& b) {
  return std::tie(a.range_m, a.instance) < std::tie(b.range_m, b.instance);
}

void add(const Hit& hit, Layers& layers) {
  // The negated comparison ensures that a NaN is no hit.
  if (!(hit.range_m <= layers.range_max_m)) return;
  int place = layers.count;
  while (place > 0 && before(hit, layers.hits[place - 1])) --place;
  if (place == layers.most) return;
  layers.count = std::min(layers.count + 1, layers.most);
  std::copy_backward(layers.hits.begin() + place, layers.hits.begin() + layers.count - 1,
                     layers.hits.begin() + layers.count);
  layers.hits[place] = hit;
}

// The rays to test against an object, as indices in a query.
struct Tried {
  int count = 0;
  std::array<unsigned, kMostRays> ray;
};

void set_ray(const Ray& local, float far, unsigned lane, RTCRayHit16& packet) {
  auto& [ray, hit] = packet;
  ray.org_x[lane] = static_cast<float>(local.origin_m.x);
  ray.org_y[lane] = static_cast<float>(local.origin_m.y);
  ray.org_z[lane] = static_cast<float>(local.origin_m.z);
  ray.dir_x[lane] = static_cast<float>(local.direction.x);
  ray.dir_y[lane] = static_cast<float>(local.direction.y);
  ray.dir_z[lane] = static_cast<float>(local.direction.z);
  ray.tnear[lane] = static_cast<float>(kNearestHit_m);
  ray.tfar[lane] = far;
  ray.time[lane] = 0;
  ray.mask[lane] = ~0u;
  ray.id[lane] = lane;
  ray.flags[lane] = 0;
  hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
}

// Traces the rays through the mesh's own hierarchy, in its frame.
void meet_mesh(const Scene& scene, const Query& query, unsigned geometry, const Tried& tried) {
  const Mesh* mesh = std::get<MeshShape>(scene.by_geometry[geometry].object->shape).mesh.get();
  // Zeroed in all lanes: Debian's Embree asserts that rays are valid even in inactive lanes.
  alignas(64) RTCRayHit16 packet{};
  alignas(64) std::array<int, kMostRays> valid{};
  unsigned used = 0;
  for (int i = 0; i < tried.count; ++i) {
    const unsigned ray = tried.ray[i];
    set_ray(local_ray(scene, query, ray, geometry), float_range(query.layers[ray].range_max_m), ray,
            packet);
    valid[ray] = -1;
    used = std::max(used, ray);
  }
  EmbreeContext context;
  init_context(context);
  intersect_packet(scene.meshes->scenes.at(mesh), context, valid.data(), packet);
  std::array<Found, kMostRays> found{};
  std::array<Hit, kMostRays> hits;
  bool any = false;
  for (int i = 0; i < tried.count; ++i) {
    const unsigned ray = tried.ray[i];
    if (packet.hit.geomID[ray] == RTC_INVALID_GEOMETRY_ID) continue;
    found[ray] = {packet.hit.geomID[ray], geometry,          packet.hit.primID[ray],
                  packet.ray.tfar[ray],   packet.hit.u[ray], packet.hit.v[ray]};
    any = true;
  }
  if (!any) return;
  refine_on_mesh(scene, query, std::span(found).first(used + 1), geometry, hits.data());
  for (int i = 0; i < tried.count; ++i) {
    const unsigned ray = tried.ray[i];
    if (found[ray].geometry != RTC_INVALID_GEOMETRY_ID) add(hits[ray], query.layers[ray]);
  }
}

void meet_closed_form(const Scene& scene, const Query& query, unsigned geometry,
                      const Tried& tried) {
  const PlacedObject& placed = scene.by_geometry[geometry];
  for (int i = 0; i < tried.count; ++i) {
    const unsigned ray = tried.ray[i];
    const Ray local = local_ray(scene, query, ray, geometry);
    const auto surface = intersect_closed_form(placed.object->shape, local);
    if (surface) add(hit_of(*surface, local.direction, placed), query.layers[ray]);
  }
}

void meet_planes(const Scene& scene, const Query& query, const Tried& tried) {
  for (std::size_t plane = 0; plane < scene.planes.size(); ++plane) {
    for (int i = 0; i < tried.count; ++i) {
      Layers& layers = query.layers[tried.ray[i]];
      if (scene.planes[plane].object->instance == layers.skip) continue;
      const std::optional<Hit> hit = plane_hit(scene, query, tried.ray[i], plane);
      if (hit) add(*hit, layers);
    }
  }
}

void along_bounds(const RTCBoundsFunctionArguments* arguments) {
  const Scene& scene = *static_cast<const AlongScene*>(arguments->geometryUserPtr)->scene;
  *arguments->bounds_o = bounds_of(scene, scene.by_geometry[arguments->primID]);
}

// Leaves the rays unchanged, so that Embree sees no hit and all rays continue.
void along_intersect(const RTCIntersectFunctionNArguments* arguments) {
  const Scene& scene = *static_cast<const AlongScene*>(arguments->geometryUserPtr)->scene;
  const auto& query = *reinterpret_cast<const Query*>(arguments->context);
  const unsigned count = arguments->N, geometry = arguments->primID;
  const PlacedObject& placed = scene.by_geometry[geometry];
  const RTCRayN* rays = RTCRayHitN_RayN(arguments->rayhit, count);
  Tried tried;
  for (unsigned lane = 0; lane < count; ++lane) {
    if (arguments->valid[lane] == 0) continue;
    const unsigned ray = RTCRayN_id(const_cast<RTCRayN*>(rays), count, lane);
    if (query.layers[ray].skip != placed.object->instance) tried.ray[tried.count++] = ray;
  }
  if (tried.count == 0) return;
  if (std::holds_alternative<MeshShape>(placed.object->shape)) {
    meet_mesh(scene, query, geometry, tried);
  } else {
    meet_closed_form(scene, query, geometry, tried);
  }
}

// Continues the rays of one tile of the fan; their layers are then in the lanes of the strip's
// query.
template <class RayHits>
void continue_tile(const AlongScene& along, const FanRays& rays, std::span<const Hit> first,
                   int first_elevation, int elevations, Strip<RayHits>& strip) {
  Tried tried;
  for (int i = 0; i < strip.columns * elevations; ++i) {
    const std::size_t column = strip.first_column + i / elevations;
    const Hit& hit = first[column * rays.fan.rays_elevation + first_elevation + i % elevations];
    Layers& layers = strip.query.layers[i];
    layers.skip = hit.instance;
    layers.count = 0;
    if (hit.instance != 0) tried.ray[tried.count++] = static_cast<unsigned>(i);
  }
  if (tried.count == 0) return;
  aim(rays, first_elevation, elevations, strip);
  for (int i = 0; i < strip.columns * elevations; ++i) {
    if (strip.query.layers[i].skip == 0) strip.valid[i] = 0;
  }
  intersect_packet(along.top, strip.query.context, strip.valid.data(), strip.packet);
  meet_planes(rays.scene, strip.query, tried);
}

// Calls visit(ray, place) for the rays of a strip, tile by tile; `place` is the index of a ray in
// its tile.
template <class BeginTile, class Visit>
void for_each_ray(const FanRays& rays, std::size_t first_column, int columns, BeginTile&& begin,
                  Visit&& visit) {
  for (int e = 0; e < rays.fan.rays_elevation; e += rays.tile.elevations) {
    const int elevations = std::min(rays.tile.elevations, rays.fan.rays_elevation - e);
    begin(e, elevations);
    for (int i = 0; i < columns * elevations; ++i) {
      visit((first_column + i / elevations) * rays.fan.rays_elevation + e + i % elevations, i);
    }
  }
}

template <class RayHits>
HitsBehind behind_in_packets(const AlongScene& along, const Fan& fan, std::span<const Hit> first,
                             const Pose& pose, double range_max_m, const Workers& workers) {
  const FanRays rays = fan_rays(*along.scene, fan, pose, range_max_m, Strip<RayHits>::kRays);
  HitsBehind behind;
  behind.offset.assign(fan.size() + 1, 0);
  std::vector<std::vector<Hit>> of_strip(rays.strips());  // in the order of for_each_ray
  workers.for_each(rays.strips(), [&](std::size_t s) {
    Strip<RayHits> strip;
    std::array<Layers, kMostRays> layers;
    for (Layers& l : layers) {
      l.most = kMostLayers - 1;
      l.range_max_m = range_max_m;
    }
    init_strip(rays, s, strip);
    strip.query.layers = layers.data();
    for_each_ray(
        rays, strip.first_column, strip.columns,
        [&](int e, int elevations) { continue_tile(along, rays, first, e, elevations, strip); },
        [&](std::size_t ray, int place) {
          const Layers& l = layers[place];
          behind.offset[ray + 1] = static_cast<std::uint32_t>(l.count);
          of_strip[s].insert(of_strip[s].end(), l.hits.begin(), l.hits.begin() + l.count);
        });
  });
  std::partial_sum(behind.offset.begin(), behind.offset.end(), behind.offset.begin());
  behind.hits.resize(behind.offset.back());
  workers.for_each(rays.strips(), [&](std::size_t s) {
    const auto breadth = static_cast<std::size_t>(rays.tile.columns);
    const std::size_t first_column = s * breadth;
    const int columns = static_cast<int>(std::min(fan.azimuth_rad.size() - first_column, breadth));
    auto next = of_strip[s].cbegin();
    for_each_ray(
        rays, first_column, columns, [](int, int) {},
        [&](std::size_t ray, int) {
          const std::uint32_t count = behind.offset[ray + 1] - behind.offset[ray];
          std::copy_n(next, count, behind.hits.begin() + behind.offset[ray]);
          next += count;
        });
    of_strip[s] = {};
  });
  return behind;
}

}  // namespace

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

AlongScene::~AlongScene() {
  if (top != nullptr) rtcReleaseScene(top);
}

void build_along_scene(const Scene& scene, AlongScene& along) {
  along.scene = &scene;
  along.rays = packet_rays(scene);
  RTCDevice device = scene.meshes->device;
  const std::lock_guard lock(scene.meshes->building);
  if (along.top == nullptr) along.top = new_scene(device);
  RTCGeometry objects = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(objects, static_cast<unsigned>(scene.by_geometry.size()));
  rtcSetGeometryUserData(objects, &along);
  rtcSetGeometryBoundsFunction(objects, along_bounds, nullptr);
  rtcSetGeometryIntersectFunction(objects, along_intersect);
  rtcCommitGeometry(objects);
  rtcAttachGeometry(along.top, objects);
  rtcReleaseGeometry(objects);
  commit(device, along.top);
}

std::vector<Hit> hits_along(const AlongScene& along, const Ray& ray, double range_max_m) {
  const Scene& scene = *along.scene;
  Layers layers;
  layers.range_max_m = range_max_m;
  Query query;
  RTCRayHit rays = one_ray(scene, ray, range_max_m, query);
  query.layers = &layers;
  intersect_one(along.top, query.context, rays);
  Tried tried;
  tried.ray[tried.count++] = 0;
  meet_planes(scene, query, tried);
  apply_fields(scene, ray, std::span(layers.hits).first(layers.count));
  return {layers.hits.begin(), layers.hits.begin() + layers.count};
}

HitsBehind trace_behind(const AlongScene& along, const Fan& fan, std::span<const Hit> hits,
                        const Pose& pose, double range_max_m, const Workers& workers) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  const auto trace = along.rays == 16  ? behind_in_packets<RTCRayHit16>
                     : along.rays == 8 ? behind_in_packets<RTCRayHit8>
                                       : behind_in_packets<RTCRayHit4>;
  HitsBehind behind = trace(along, fan, hits, pose, range_max_m, workers);
  if (along.scene->uneven.empty()) return behind;
  workers.for_each(fan.azimuth_rad.size(), [&](std::size_t column) {
    for (std::size_t e = 0; e < fan.elevation_rad.size(); ++e) {
      const std::size_t ray = column * fan.elevation_rad.size() + e;
      const Vec3 direction = unit_vector(fan.azimuth_rad[column], fan.elevation_rad[e]);
      apply_fields(*along.scene, {pose.position_m, rotate(pose.rotation, direction)},
                   std::span(behind.hits)
                       .subspan(behind.offset[ray], behind.offset[ray + 1] - behind.offset[ray]));
    }
  });
  return behind;
}

}  // namespace ensonify
