#include "trace/refine.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/compile_targets.h"

namespace ensonify {
namespace {

using Lanes = std::array<double, kMostRays>;
using FloatLanes = std::array<float, kMostRays>;

// Hits on triangles of one mesh, in its frame, in separate arrays.
struct TriangleHits {
  int count = 0;
  std::array<int, kMostRays> ray;
  alignas(64) std::array<std::array<FloatLanes, 3>, 3> corner;  // [corner][x, y, z]
  FloatLanes embree_range_m;
  alignas(64) std::array<Lanes, 3> direction;  // in the world at first, then in the mesh's frame
  alignas(64) std::array<Lanes, 3> smooth;     // interpolated normals, if the mesh has any
  alignas(64) Lanes range_m, cos_incidence, normal_x, normal_y, normal_z;  // results, in the world
};

Vec3 at(const std::array<Lanes, 3>& lanes, int i) {
  return {lanes[0][i], lanes[1][i], lanes[2][i]};
}

double cos_incidence(Vec3 direction, Vec3 normal) {
  // With this order of arguments a NaN stays NaN, and surface_scatterers leaves it out.
  return std::min(std::abs(dot(direction, normal)), 1.0);
}

std::array<double, 3> weights_of(const Found& found) {
  const double u = found.u, v = found.v;
  return {1 - u - v, u, v};
}

// Loads the triangles of all rays into the cache at once: most are not there, and waiting for them
// one after the other takes longer than all other steps.
void prefetch(const Mesh& mesh, std::span<const Found> found, unsigned instance) {
  for (const Found& f : found) {
    if (f.instance == instance) __builtin_prefetch(&mesh.triangles[f.triangle]);
  }
  for (const Found& f : found) {
    if (f.instance != instance) continue;
    for (const std::uint32_t corner : mesh.triangles[f.triangle]) {
      __builtin_prefetch(&mesh.vertices[corner]);
      if (!mesh.normals.empty()) __builtin_prefetch(&mesh.normals[corner]);
    }
  }
}

// Collects the rays of a query that met one mesh.
void gather(const Mesh& mesh, const Query& query, std::span<const Found> found, unsigned instance,
            TriangleHits& t) {
  prefetch(mesh, found, instance);
  t.count = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i].instance != instance) continue;
    const int lane = t.count++;
    t.ray[lane] = static_cast<int>(i);
    const auto& corners = mesh.triangles[found[i].triangle];
    for (int k = 0; k < 3; ++k) {
      for (int x = 0; x < 3; ++x) t.corner[k][x][lane] = mesh.vertices[corners[k]][x];
    }
    t.embree_range_m[lane] = found[i].range_m;
    t.direction[0][lane] = query.directions.x[i];
    t.direction[1][lane] = query.directions.y[i];
    t.direction[2][lane] = query.directions.z[i];
    if (mesh.normals.empty()) continue;
    const auto weight = weights_of(found[i]);
    for (int x = 0; x < 3; ++x) {
      t.smooth[x][lane] = weight[0] * mesh.normals[corners[0]][x] +
                          weight[1] * mesh.normals[corners[1]][x] +
                          weight[2] * mesh.normals[corners[2]][x];
    }
  }
}

// Ranges and normals on the triangles that Embree found, in double precision. Keeps Embree's range
// if the ray lies in the triangle's plane, because the quotient is not valid there.
ENSONIFY_VECTOR_CLONES void meet_triangles(Vec3 local_origin_m, Quat rotation, TriangleHits& t) {
  for (int i = 0; i < t.count; ++i) {
    const auto corner = [&](int k) {
      return Vec3{t.corner[k][0][i], t.corner[k][1][i], t.corner[k][2][i]};
    };
    const Vec3 direction = rotate(conjugate(rotation), at(t.direction, i));
    t.direction[0][i] = direction.x;
    t.direction[1][i] = direction.y;
    t.direction[2][i] = direction.z;
    const Vec3 a = corner(0);
    const Vec3 normal = cross(corner(1) - a, corner(2) - a);
    const double embree_range = t.embree_range_m[i];
    const double range = dot(a - local_origin_m, normal) / dot(direction, normal);
    const bool sound = std::abs(range - embree_range) < 0.01 * embree_range + 1e-3;
    t.range_m[i] = sound ? range : embree_range;
    const Vec3 unit = normalized(normal);
    t.cos_incidence[i] = cos_incidence(direction, unit);
    const Vec3 in_world = rotate(rotation, unit);
    t.normal_x[i] = in_world.x;
    t.normal_y[i] = in_world.y;
    t.normal_z[i] = in_world.z;
  }
}

// Replaces the normals of faces by interpolated ones, except where these are missing or cancel.
ENSONIFY_VECTOR_CLONES void smooth_normals(Quat rotation, TriangleHits& t) {
  for (int i = 0; i < t.count; ++i) {
    const Vec3 smooth = at(t.smooth, i);
    const bool sound = length(smooth) > 1e-6;
    const Vec3 unit = normalized(smooth);
    const double cosine = cos_incidence(at(t.direction, i), unit);
    const Vec3 in_world = rotate(rotation, unit);
    t.cos_incidence[i] = sound ? cosine : t.cos_incidence[i];
    t.normal_x[i] = sound ? in_world.x : t.normal_x[i];
    t.normal_y[i] = sound ? in_world.y : t.normal_y[i];
    t.normal_z[i] = sound ? in_world.z : t.normal_z[i];
  }
}

float reflectivity_at(const Mesh& mesh, const Found& found) {
  const auto& corner = mesh.triangles[found.triangle];
  const auto weight = weights_of(found);
  double factor = 0;
  for (int i = 0; i < 3; ++i) factor += weight[i] * mesh.reflectivity[corner[i]];
  return static_cast<float>(factor);
}

// The weights of the corners of a triangle at a point of its plane.
std::array<double, 3> weights_at(const Mesh& mesh, const std::array<std::uint32_t, 3>& corner,
                                 Vec3 p) {
  const Vec3 a = to_vec3(mesh.vertices[corner[0]]);
  const Vec3 ab = to_vec3(mesh.vertices[corner[1]]) - a, ac = to_vec3(mesh.vertices[corner[2]]) - a;
  const Vec3 normal = cross(ab, ac);
  const double square = dot(normal, normal);
  const double b = dot(cross(p - a, ac), normal) / square;
  const double c = dot(cross(ab, p - a), normal) / square;
  return {1 - b - c, b, c};
}

// The factor of an image on a mesh at a point of one of its triangles, in the mesh's frame.
float image_at(const ReflectivityImage& image, const Mesh& mesh, unsigned triangle, Vec3 p) {
  const auto& corner = mesh.triangles[triangle];
  const auto weight = weights_at(mesh, corner, p);
  double u = 0, v = 0;
  for (int i = 0; i < 3; ++i) {
    u += weight[i] * mesh.uv[corner[i]][0];
    v += weight[i] * mesh.uv[corner[i]][1];
  }
  return image.at(u, v);
}

// Replaces the nearest hit by a hit on a plane if the latter is nearer.
void refine_on_planes(const Scene& scene, const Query& query, unsigned ray, Hit& nearest) {
  for (std::size_t i = 0; i < scene.planes.size(); ++i) {
    const std::optional<Hit> hit = plane_hit(scene, query, ray, i);
    if (!hit || (nearest.instance != 0 && hit->range_m >= nearest.range_m)) continue;
    nearest = *hit;
  }
}

}  // namespace

Hit hit_of(const SurfaceHit& surface, Vec3 local_direction, const PlacedObject& placed) {
  Hit hit;
  hit.range_m = surface.range_m;
  hit.cos_incidence = static_cast<float>(cos_incidence(local_direction, surface.normal));
  hit.instance = placed.object->instance;
  hit.normal = rotate(placed.pose.rotation, surface.normal);
  return hit;
}

void refine_on_mesh(const Scene& scene, const Query& query, std::span<const Found> found,
                    unsigned instance, Hit* hits) {
  const auto& [object, pose] = scene.by_geometry[instance];
  const MeshShape& shape = std::get<MeshShape>(object->shape);
  const Mesh& mesh = *shape.mesh;
  const Vec3 origin = local_origin(scene, query, instance);
  TriangleHits t;
  gather(mesh, query, found, instance, t);
  meet_triangles(origin, pose.rotation, t);
  if (!mesh.normals.empty()) smooth_normals(pose.rotation, t);
  const std::vector<std::uint16_t>& of_part = object->parts.of_part;
  for (int i = 0; i < t.count; ++i) {
    const Found& f = found[t.ray[i]];
    Hit& hit = hits[t.ray[i]];
    hit = {t.range_m[i],
           static_cast<float>(t.cos_incidence[i]),
           object->instance,
           1,
           0,
           0,
           {t.normal_x[i], t.normal_y[i], t.normal_z[i]}};
    if (!of_part.empty()) hit.part = hit.own_part = of_part[mesh.part[f.triangle]];
    if (!mesh.reflectivity.empty()) hit.reflectivity = reflectivity_at(mesh, f);
    if (shape.image && !mesh.uv.empty()) {
      const Vec3 local = origin + t.range_m[i] * at(t.direction, i);
      hit.reflectivity = image_at(*shape.image, mesh, f.triangle, local);
    }
  }
}

VertexColor color_of(const Scene& scene, const Found& found, const Hit& hit) {
  if (found.geometry == RTC_INVALID_GEOMETRY_ID || found.instance == RTC_INVALID_GEOMETRY_ID)
    return {};
  const WorldObject& object = *scene.by_geometry[found.instance].object;
  const Mesh& mesh = *std::get<MeshShape>(object.shape).mesh;
  const bool is_bare = hit.instance == object.instance && hit.part == hit.own_part;
  if (mesh.colors.empty() || !is_bare) return {};
  const auto& [a, b, c] = mesh.triangles[found.triangle];
  std::array<double, 3> color{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double first = mesh.colors[a][i];
    color[i] = first + double{found.u} * (mesh.colors[b][i] - first) +
               double{found.v} * (mesh.colors[c][i] - first);
  }
  if (std::isnan(color[0])) return {};
  return color;
}

std::optional<Hit> plane_hit(const Scene& scene, const Query& query, unsigned ray,
                             std::size_t plane) {
  const PlacedObject& placed = scene.planes[plane];
  const Ray local{query.origins != nullptr ? query.origins->planes_m[plane]
                                           : inverse_transform_point(placed.pose, query.origin_m),
                  rotate(conjugate(placed.pose.rotation), query.directions[ray])};
  const std::optional<SurfaceHit> hit = intersect_closed_form(placed.object->shape, local);
  if (!hit) return std::nullopt;
  return hit_of(*hit, local.direction, placed);
}

void apply_fields(const Scene& scene, const Ray& ray, std::span<Hit> hits) {
  if (scene.uneven.empty()) return;
  for (Hit& hit : hits) {
    if (hit.instance == 0 || hit.instance >= scene.uneven.size()) continue;
    const auto& [object, pose] = scene.uneven[hit.instance];
    if (object == nullptr || hit.part >= object->fields.size()) continue;
    const MaterialFields& fields = object->fields[hit.part];
    const Vec3 local = inverse_transform_point(pose, ray.origin_m + hit.range_m * ray.direction);
    const bool grown = fields.growth && fields.growth->at(local) > 0.5f;
    if (grown) hit.part = fields.growth_part;
    const auto& texture = grown ? fields.growth_texture : fields.texture;
    if (texture) hit.reflectivity *= texture->at(local);
  }
}

void refine(const Scene& scene, const Query& query, std::span<const Found> found,
            double range_max_m, Hit* hits) {
  const auto count = static_cast<unsigned>(found.size());
  for (unsigned i = 0; i < count; ++i) {
    const Found& f = found[i];
    if (f.geometry == RTC_INVALID_GEOMETRY_ID) {
      hits[i] = {};
    } else if (f.instance == RTC_INVALID_GEOMETRY_ID) {
      const ClosedFormHit& form = query.closed_form[i];
      hits[i] = hit_of(form.surface, form.local_direction, scene.by_geometry[f.geometry]);
    } else {
      const auto same = [&](const Found& other) { return other.instance == f.instance; };
      // The first ray on a mesh refines all rays on it.
      if (std::none_of(found.begin(), found.begin() + i, same)) {
        refine_on_mesh(scene, query, found, f.instance, hits);
      }
    }
  }
  for (unsigned i = 0; i < count; ++i) {
    refine_on_planes(scene, query, i, hits[i]);
    if (!(hits[i].range_m <= range_max_m)) hits[i] = {};
    apply_fields(scene, {query.origin_m, query.directions[i]}, {hits + i, 1});
  }
}

}  // namespace ensonify
