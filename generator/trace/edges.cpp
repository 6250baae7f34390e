#include "trace/edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "acoustics/scattering.h"
#include "core/units.h"
#include "trace/echo.h"

namespace ensonify {
namespace {

constexpr double kSharp_rad = radians(40);

bool diffracts(const Material& material) {
  return material.coherent == CoherentModel::kirchhoff && material.edges;
}

void add_edges(const BoxShape& box, double, std::vector<Edge>& edges) {
  if (box.inside) return;  // a room has no edge that the sonar sees from outside of the wedge
  const Vec3 h = box.half_size_m;
  for (const double s : {-1.0, 1.0}) {
    for (const double t : {-1.0, 1.0}) {
      edges.push_back({{{0, s * h.y, t * h.z}, {h.x, 0, 0}}, {0, -s, 0}, {0, 0, -t}});
      edges.push_back({{{s * h.x, 0, t * h.z}, {0, h.y, 0}}, {-s, 0, 0}, {0, 0, -t}});
      edges.push_back({{{s * h.x, t * h.y, 0}, {0, 0, h.z}}, {-s, 0, 0}, {0, -t, 0}});
    }
  }
}

void add_edges(const CylinderShape& cylinder, double wavelength_m, std::vector<Edge>& edges) {
  const double radius = cylinder.radius_m;
  // The phase between an arc of length l and its chord is 2k l^2/(8 radius).
  const double longest = std::sqrt(kLineBend_rad * radius * wavelength_m / (kPi / 2));
  const int count = std::max(16, static_cast<int>(std::ceil(2 * kPi * radius / longest)));
  for (int i = 0; i < count; ++i) {
    const double a = 2 * kPi * (i + 0.5) / count;
    const Vec3 out{std::cos(a), std::sin(a), 0}, along{-std::sin(a), std::cos(a), 0};
    for (const double side : {-1.0, 1.0}) {
      const Vec3 top{0, 0, side * cylinder.half_height_m};
      edges.push_back(
          {{radius * out + top, (kPi * radius / count) * along}, -out, {0, 0, -side}});
    }
  }
}

void add_edges(const SphereShape&, double, std::vector<Edge>&) {}
void add_edges(const PlaneShape&, double, std::vector<Edge>&) {}

// The sides of a mesh's triangles, so that those at one place are neighbors.
struct Side {
  std::uint32_t a = 0, b = 0;  // the first vertices at their places, a < b
  std::uint32_t triangle = 0, apex = 0;

  auto ends() const { return std::pair{a, b}; }
};

std::vector<Side> sides_of(const Mesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size()), same(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return mesh.vertices[i]; });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool again = i > 0 && mesh.vertices[order[i]] == mesh.vertices[order[i - 1]];
    same[order[i]] = again ? same[order[i - 1]] : order[i];
  }
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const auto& corners = mesh.triangles[t];
      const auto [a, b] = std::minmax(same[corners[i]], same[corners[(i + 1) % 3]]);
      if (a != b) sides.push_back({a, b, t, same[corners[(i + 2) % 3]]});
    }
  }
  std::ranges::stable_sort(sides, {}, &Side::ends);
  return sides;
}

std::uint16_t part_of(const Mesh& mesh, const PartMaterials& parts, std::uint32_t triangle) {
  return mesh.part.empty() || parts.of_part.empty() ? std::uint16_t{0}
                                                    : parts.of_part[mesh.part[triangle]];
}

// From an edge into the face with the corner `apex`, unit length.
Vec3 into_face(const Mesh& mesh, Vec3 middle, Vec3 along, std::uint32_t apex) {
  const Vec3 way = to_vec3(mesh.vertices[apex]) - middle;
  return normalized(way - dot(way, along) * along);
}

void add_mesh_edges(const Mesh& mesh, const PartMaterials& parts, std::vector<Edge>& edges) {
  const std::vector<Side> sides = sides_of(mesh);
  for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
    next = i + 1;
    while (next < sides.size() && sides[next].ends() == sides[i].ends()) ++next;
    const std::uint16_t part = part_of(mesh, parts, sides[i].triangle);
    if (next - i > 2 || part_of(mesh, parts, sides[next - 1].triangle) != part) continue;
    const Vec3 a = to_vec3(mesh.vertices[sides[i].a]), b = to_vec3(mesh.vertices[sides[i].b]);
    const Vec3 half = 0.5 * (b - a), middle = 0.5 * (a + b), along = normalized(half);
    const Vec3 first = into_face(mesh, middle, along, sides[i].apex);
    const Vec3 second = next - i == 1 ? first : into_face(mesh, middle, along, sides[i + 1].apex);
    if (next - i == 2 && -dot(first, second) > std::cos(kSharp_rad)) continue;
    // The third corner of a sliver may lie on the edge.
    if (!std::isfinite(dot(first, second))) continue;
    edges.push_back({{middle, half}, first, second, part});
  }
}

// An edge in the world.
struct PlacedEdge {
  Edge edge;
  Vec3 along;
  const Material& material;
  std::uint32_t instance = 0;
};

// What the pieces of one ping share.
struct EdgeEchoes {
  const PlacedWorld& view;
  const SurfaceScattering& scattering;
  double wavelength_m;

  bool is_seen(Vec3 place_m, const Edge& edge) const;
  std::optional<Scatterer> piece(const PlacedEdge& placed, Vec3 place_m, double length_m) const;
  void add(const BodyEdges& body, const Edge& local, std::uint64_t key,
           std::vector<Scatterer>& scatterers) const;
};

// The wedge as the sonar sees it: its exterior angle on this side, and the angle of the ray.
struct SeenWedge {
  double exterior_rad = 0, angle_rad = 0;

  // The cosine of incidence on the face that is seen more nearly at normal incidence.
  double cos_incidence(double sin_beta) const {
    return sin_beta * std::max(std::sin(angle_rad), std::sin(exterior_rad - angle_rad));
  }
};

SeenWedge seen_wedge(const Edge& edge, Vec3 along, Vec3 to_sonar) {
  const Vec3 side = cross(along, edge.first);
  const auto angle_of = [&](Vec3 v) {
    const double angle = std::atan2(dot(v, side), dot(v, edge.first));
    return angle < 0 ? angle + 2 * kPi : angle;
  };
  const double sonar = angle_of(to_sonar);
  if (edge.is_rim()) return {2 * kPi, sonar};
  const double second = angle_of(edge.second);
  return sonar < second ? SeenWedge{second, sonar} : SeenWedge{2 * kPi - second, sonar - second};
}

// Looks past the edge, so that the ray does not end on the body itself.
bool EdgeEchoes::is_seen(Vec3 place_m, const Edge& edge) const {
  const Vec3 away = -normalized(edge.first + edge.second);
  const Vec3 eye = view.sonar_in_world.position_m;
  const double range = length(place_m - eye);
  const Vec3 way = place_m + (2 * kOnSurface * range) * away - eye;
  const Hit hit = view.tracer.first_hit({eye, normalized(way)}, range);
  return hit.instance == 0 || hit.range_m >= range * (1 - kOnSurface);
}

std::optional<Scatterer> EdgeEchoes::piece(const PlacedEdge& placed, Vec3 place_m,
                                           double length_m) const {
  std::optional<Scatterer> s =
      echo_at(place_m, view.sonar_in_world, scattering.sonar, scattering.water);
  if (!s) return std::nullopt;
  const double range = length(s->position_m);
  const Vec3 back = (1 / range) * (view.sonar_in_world.position_m - place_m);
  const double cos_beta = dot(back, placed.along);
  const double sin_beta = std::sqrt(std::max(0.0, 1 - cos_beta * cos_beta));
  const SeenWedge seen = seen_wedge(placed.edge, placed.along, back);
  if (seen.exterior_rad < kPi + kSharp_rad || sin_beta < 1e-6) return std::nullopt;
  if (!is_seen(place_m, placed.edge)) return std::nullopt;
  const double cosine = std::clamp(seen.cos_incidence(sin_beta), 0.0, 1.0);
  const Material& material = placed.material;
  const double reflection =
      coherent_reflection(material.reflection, material.roughness_rms_m, wavelength_m, cosine);
  s->mean = static_cast<float>(
      std::abs(reflection) * length_m / (2 * kPi) * sinc(2 * length_m * cos_beta / wavelength_m) *
      fringe_diffraction({seen.exterior_rad, reflection > 0}, seen.angle_rad));
  s->cos_incidence = static_cast<float>(cosine);
  s->instance = placed.instance;
  return s;
}

void EdgeEchoes::add(const BodyEdges& body, const Edge& local, std::uint64_t key,
                     std::vector<Scatterer>& scatterers) const {
  const WorldObject& object = view.world.objects[body.object];
  const Material& material = material_at(scattering, object.instance, local.part);
  if (!diffracts(material)) return;
  const Pose& pose = view.object_in_world[body.object];
  const auto turned = [&](Vec3 v) { return rotate(pose.rotation, v); };
  const PlacedEdge placed{{{transform_point(pose, local.line.middle_m), turned(local.line.half_m)},
                           turned(local.first), turned(local.second), local.part},
                          normalized(turned(local.line.half_m)),
                          material,
                          object.instance};
  const Vec3 eye = view.sonar_in_world.position_m;
  const auto line = within_range(placed.edge.line, eye, scattering.sonar.range_max_m);
  if (!line) return;
  const int count = pieces_of(*line, eye, scattering.sonar, scattering.water);
  for (int i = 0; i < count; ++i) {
    std::optional<Scatterer> s =
        piece(placed, piece_middle_m(*line, i, count), line->length_m() / count);
    if (!s || !(std::norm(s->mean) > 0)) continue;
    s->key = key + static_cast<std::uint64_t>(i);
    scatterers.push_back(*s);
  }
}

}  // namespace

std::vector<BodyEdges> diffracting_edges(const World& world, double wavelength_m) {
  std::vector<BodyEdges> bodies;
  std::map<const Mesh*, std::size_t> first_with;  // of meshes without parts, in `bodies`
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const WorldObject& object = world.objects[i];
    if (!diffracts(object.material) && std::ranges::none_of(object.parts.materials, diffracts)) {
      continue;
    }
    BodyEdges body{i, {}};
    if (const auto* mesh = std::get_if<MeshShape>(&object.shape)) {
      if (mesh->ground) continue;
      const bool has_parts = !object.parts.of_part.empty();
      const auto known = first_with.find(mesh->mesh.get());
      if (known != first_with.end() && !has_parts) {
        body.edges = bodies[known->second].edges;
      } else {
        add_mesh_edges(*mesh->mesh, object.parts, body.edges);
        if (!has_parts) first_with[mesh->mesh.get()] = bodies.size();
      }
    } else {
      std::visit(
          [&](const auto& shape) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(shape)>, MeshShape>) {
              add_edges(shape, wavelength_m, body.edges);
            }
          },
          object.shape);
    }
    bodies.push_back(std::move(body));
  }
  return bodies;
}

std::vector<Scatterer> edge_scatterers(const PlacedWorld& view, const SurfaceScattering& scattering,
                                       const Workers& workers) {
  const EdgeEchoes echoes{view, scattering,
                          scattering.water.sound_speed_m_s / scattering.sonar.frequency_hz};
  std::vector<Scatterer> all;
  std::uint64_t number = 0;
  for (const BodyEdges& body : scattering.edges) {
    std::vector<std::vector<Scatterer>> by_edge(body.edges.size());
    workers.for_each(body.edges.size(), [&](std::size_t i) {
      const std::uint64_t key = edge_key(number + i);
      echoes.add(body, body.edges[i], key, by_edge[i]);
    });
    number += body.edges.size();
    append(by_edge, all);
  }
  return all;
}

}  // namespace ensonify
