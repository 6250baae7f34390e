#include "trace/continue.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "core/error.h"
#include "trace/packets.h"
#include "trace/refine.h"
#include "trace/strip.h"

namespace ensonify {
namespace {

bool before(const Hit& a, const Hit& b) {
  return std::tie(a.range_m, a.instance) < std::tie(b.range_m, b.instance);
}

void add(const Hit& hit, Layers& layers) {
  // In this order a NaN is no hit.
  if (!(hit.range_m <= layers.range_max_m)) return;
  int place = layers.count;
  while (place > 0 && before(hit, layers.hits[place - 1])) --place;
  if (place == layers.most) return;
  layers.count = std::min(layers.count + 1, layers.most);
  std::copy_backward(layers.hits.begin() + place, layers.hits.begin() + layers.count - 1,
                     layers.hits.begin() + layers.count);
  layers.hits[place] = hit;
}

// Rays of a query that an object is to be tried with, by their places in it.
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

// Through the mesh's own hierarchy, in its frame.
void meet_mesh(const Scene& scene, const Query& query, unsigned geometry, const Tried& tried) {
  const Mesh* mesh = std::get<MeshShape>(scene.by_geometry[geometry].object->shape).mesh.get();
  // All lanes: Debian's Embree asserts that rays are sound also in those that are none.
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

// Leaves the rays as they are: to Embree none of them hits anything.
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

// One tile of the fan: continues its rays, whose layers are then those of the strip's lanes.
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

// Calls visit(ray, place) for the rays of a strip, tile by tile, each with its place in its tile.
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
  return {layers.hits.begin(), layers.hits.begin() + layers.count};
}

HitsBehind trace_behind(const AlongScene& along, const Fan& fan, std::span<const Hit> hits,
                        const Pose& pose, double range_max_m, const Workers& workers) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  const auto trace = along.rays == 16  ? behind_in_packets<RTCRayHit16>
                     : along.rays == 8 ? behind_in_packets<RTCRayHit8>
                                       : behind_in_packets<RTCRayHit4>;
  return trace(along, fan, hits, pose, range_max_m, workers);
}

}  // namespace ensonify
