#include <algorithm>
#include <cmath>
#include <optional>

#include "acoustics/scattering.h"
#include "trace/echo.h"
#include "trace/scatter.h"

namespace ensonify {
namespace {

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
  if (seen.exterior_rad < kPi + kSharpEdge_rad || sin_beta < 1e-6) return std::nullopt;
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
                           turned(local.first),
                           turned(local.second),
                           local.part},
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
