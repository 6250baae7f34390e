#include "trace/refracted.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/scatterers.h"

namespace ensonify {
namespace {

// Largest distance between a chord and its ray.
constexpr double kSagitta_m = 1e-4;
// A chord is traced this far beyond its end, so that no surface is missed between two chords.
constexpr double kOverlap_m = 1e-3;
// Least cosine between ray and normal at which the tangent plane determines where the ray crosses
// it.
constexpr double kGrazing = 1e-6;

// A part of an arc.
struct BentPiece {
  RayArc arc;
  double from_m = 0, to_m = 0;  // along the arc
};

// The vertical plane of a ray.
struct RayPlane {
  Vec3 origin_m, ahead;  // ahead: horizontal, of unit length

  Vec3 at(const RayPoint& p) const {
    const Vec3 level = p.x_m * ahead;
    return {origin_m.x + level.x, origin_m.y + level.y, p.z_m};
  }
  Vec3 direction(const RayPoint& p) const {
    return {p.cos_phi * ahead.x, p.cos_phi * ahead.y, p.sin_phi};
  }
};

RayPlane plane_of(Vec3 origin_m, Vec3 direction) {
  const double level = std::hypot(direction.x, direction.y);
  return {origin_m, level > 0 ? Vec3{direction.x / level, direction.y / level, 0} : Vec3{1, 0, 0}};
}

// One chord. It extends over several layers while the ray stays near it.
struct Chord {
  static constexpr int kMostPieces = 64;

  RayPlane plane;
  std::array<BentPiece, kMostPieces> pieces;
  int count = 0;
  double way_m = 0;      // along the pieces
  double turns_rad = 0;  // upper limit of the total
  RayPoint start, end;

  Ray ray() const { return {plane.at(start), normalized(plane.at(end) - plane.at(start))}; }
  double length_m() const { return length(plane.at(end) - plane.at(start)); }

  // Whether the ray stays near the chord with one more piece. A curve of length L that turns by t
  // in total lies within L t / 4 of its chord, an arc within L t / 8.
  bool takes(double more_m, double more_rad) const {
    if (count == kMostPieces) return false;
    const double parts = count == 0 ? 8 : 4;
    return (way_m + more_m) * (turns_rad + more_rad) <= parts * kSagitta_m;
  }
  void add(const RayArc& arc, double from_m, double to_m) {
    if (count == 0) start = from_m == 0 ? arc.start : point_on(arc, from_m);
    pieces[count++] = {arc, from_m, to_m};
    way_m += to_m - from_m;
    turns_rad += std::abs(arc.curvature_m) * (to_m - from_m);
  }
};

// Follows a ray chord by chord; calls visit(chord) until it returns false or the time has passed.
template <class Visit>
void walk(const RefractedRays& rays, Vec3 direction, double time_max_s, Visit&& visit) {
  Chord chord;
  chord.plane = plane_of(rays.sonar_in_world.position_m, direction);
  const double level = std::hypot(direction.x, direction.y);
  RayArc arc = start_ray(rays.layers, rays.sonar_in_world.position_m.z, level, direction.z);
  const auto flush = [&] {
    if (chord.count == 0) return true;
    const BentPiece& last = chord.pieces[chord.count - 1];
    chord.end = point_on(last.arc, last.to_m);
    const bool more = visit(std::as_const(chord)) && chord.end.time_s < time_max_s;
    chord.count = 0;
    chord.way_m = chord.turns_rad = 0;
    return more;
  };
  for (;;) {
    const double fastest = rays.layers.fastest_m_s;
    const double left_m = (time_max_s - arc.start.time_s) * fastest;
    if (!(left_m > 0)) break;
    const double length = std::min(arc.length_m, left_m);
    const double curvature = std::abs(arc.curvature_m);
    if (!chord.takes(length, length * curvature) && !flush()) return;
    const double parts = std::ceil(length * std::sqrt(curvature / (8 * kSagitta_m)));
    for (int i = 0, n = std::max(1, static_cast<int>(parts)); i < n; ++i) {
      if (i > 0 && !flush()) return;
      chord.add(arc, length * i / n, length * (i + 1) / n);
    }
    if (length < arc.length_m) break;
    arc = next_arc(rays.layers, arc);
  }
  flush();
}

// The point of the ray at way_m from the start of the chord. Outside the chord, its first and last
// arcs are extended.
RayPoint point_along(const Chord& chord, double way_m) {
  for (int i = 0; i + 1 < chord.count; ++i) {
    const BentPiece& piece = chord.pieces[i];
    if (way_m < piece.to_m - piece.from_m) return point_on(piece.arc, piece.from_m + way_m);
    way_m -= piece.to_m - piece.from_m;
  }
  const BentPiece& last = chord.pieces[chord.count - 1];
  return point_on(last.arc, last.from_m + way_m);
}

// The point where the ray crosses the tangent plane at its chord's hit, by Newton's method. At
// grazing incidence, where that fails, the position of the hit along the chord.
RayPoint crossing(const Chord& chord, const Ray& ray, const Hit& hit) {
  const Vec3 met = ray.origin_m + hit.range_m * ray.direction;
  const double guess = hit.range_m * chord.way_m / chord.length_m();
  double way = guess;
  for (int i = 0; i < 8; ++i) {
    const RayPoint at = point_along(chord, way);
    const double slope = dot(chord.plane.direction(at), hit.normal);
    if (std::abs(slope) < kGrazing) break;
    const double step = dot(chord.plane.at(at) - met, hit.normal) / slope;
    way -= step;
    if (std::abs(way - guess) > 2 * kSagitta_m / std::abs(slope)) break;
    if (std::abs(step) < 1e-12 * (1 + way)) return point_along(chord, way);
  }
  return point_along(chord, guess);
}

RefractedHit bent_hit(const RefractedRays& rays, const Chord& chord, const Ray& ray,
                      const Hit& on_chord) {
  const RayPoint at = crossing(chord, ray, on_chord);
  RefractedHit refracted{on_chord, {}};
  refracted.hit.range_m = rays.instrument_speed_m_s * at.time_s;
  refracted.hit.cos_incidence =
      static_cast<float>(std::min(std::abs(dot(chord.plane.direction(at), on_chord.normal)), 1.0));
  refracted.path = path_to(rays, chord.plane.ahead, at);
  return refracted;
}

Vec3 direction_of(const RefractedRays& rays, const Fan& fan, std::size_t column, std::size_t e) {
  return rotate(rays.sonar_in_world.rotation,
                unit_vector(fan.azimuth_rad[column], fan.elevation_rad[e]));
}

}  // namespace

RefractedRays refracted_rays(const Tracer& tracer, const Pose& sonar_in_world, const Sonar& sonar,
                             const Water& water) {
  ENSONIFY_ASSERT(bends(water));
  return {tracer, make_layers(*water.profile), sonar_in_world, water.sound_speed_m_s,
          sonar.frequency_hz};
}

RayPath path_to(const RefractedRays& rays, Vec3 direction, const RayPoint& point) {
  const Vec3 origin = rays.sonar_in_world.position_m;
  RayPath path;
  path.position_m =
      inverse_transform_point(rays.sonar_in_world, plane_of(origin, direction).at(point));
  path.length_m = point.path_m;
  path.tube_area_m2 = tube_area_m2(point);
  path.spreading_m2 =
      two_way_spreading_m2(point, sound_speed_at(rays.layers, origin.z), rays.frequency_hz);
  path.curvature_radius_m = point.lateral_m;
  return path;
}

std::optional<RefractedHit> first_refracted_hit(const RefractedRays& rays, Vec3 direction,
                                                double time_max_s) {
  std::optional<RefractedHit> found;
  walk(rays, direction, time_max_s, [&](const Chord& chord) {
    const Ray ray = chord.ray();
    const Hit hit = rays.tracer.first_hit(ray, chord.length_m() + kOverlap_m);
    if (hit.instance == 0) return true;
    found = bent_hit(rays, chord, ray, hit);
    return false;
  });
  if (found && found->hit.range_m > rays.instrument_speed_m_s * time_max_s) return std::nullopt;
  return found;
}

std::vector<RefractedHit> refracted_hits_along(const RefractedRays& rays, Vec3 direction,
                                               double time_max_s, std::uint32_t skip, int most) {
  std::vector<RefractedHit> found;
  const auto known = [&](const Hit& hit) {
    return hit.instance == skip || std::ranges::any_of(found, [&](const RefractedHit& other) {
             return other.hit.instance == hit.instance;
           });
  };
  walk(rays, direction, time_max_s, [&](const Chord& chord) {
    const Ray ray = chord.ray();
    for (const Hit& hit : rays.tracer.hits_along(ray, chord.length_m() + kOverlap_m)) {
      if (!known(hit)) found.push_back(bent_hit(rays, chord, ray, hit));
    }
    return static_cast<int>(found.size()) < most;
  });
  std::erase_if(found, [&](const RefractedHit& refracted) {
    return refracted.hit.range_m > rays.instrument_speed_m_s * time_max_s;
  });
  if (static_cast<int>(found.size()) > most) found.resize(most);
  return found;
}

FanHits trace_fan(const Tracer& tracer, const Fan& fan, const Pose& sonar_in_world,
                  const Sonar& sonar, const Water& water, const Workers& workers) {
  if (!bends(water)) {
    return {tracer.trace_fan(fan, sonar_in_world, sonar.range_max_m, workers), {}};
  }
  const RefractedRays rays = refracted_rays(tracer, sonar_in_world, sonar, water);
  const double time_max_s = sonar.range_max_m / water.sound_speed_m_s;
  FanHits all;
  all.hits.resize(fan.size());
  all.paths.resize(fan.size());
  workers.for_each(fan.azimuth_rad.size(), [&](std::size_t column) {
    const std::size_t first = column * fan.rays_elevation;
    for (std::size_t e = 0; e < fan.elevation_rad.size(); ++e) {
      const auto met = first_refracted_hit(rays, direction_of(rays, fan, column, e), time_max_s);
      if (!met) continue;
      all.hits[first + e] = met->hit;
      all.paths[first + e] = met->path;
    }
  });
  return all;
}

FanHitsBehind trace_behind(const Tracer& tracer, const Fan& fan, std::span<const Hit> hits,
                           const Pose& sonar_in_world, const Sonar& sonar, const Water& water,
                           const Workers& workers) {
  if (!bends(water)) {
    return {tracer.trace_behind(fan, hits, sonar_in_world, sonar.range_max_m, workers), {}};
  }
  ENSONIFY_ASSERT(hits.size() == fan.size());
  const RefractedRays rays = refracted_rays(tracer, sonar_in_world, sonar, water);
  const double time_max_s = sonar.range_max_m / water.sound_speed_m_s;
  FanHitsBehind all;
  all.behind.offset.assign(fan.size() + 1, 0);
  std::vector<std::vector<RefractedHit>> of_column(fan.azimuth_rad.size());
  workers.for_each(of_column.size(), [&](std::size_t column) {
    for (std::size_t e = 0; e < fan.elevation_rad.size(); ++e) {
      const std::size_t ray = column * fan.rays_elevation + e;
      if (hits[ray].instance == 0) continue;
      const auto found = refracted_hits_along(rays, direction_of(rays, fan, column, e), time_max_s,
                                              hits[ray].instance, kMostLayers - 1);
      all.behind.offset[ray + 1] = static_cast<std::uint32_t>(found.size());
      of_column[column].insert(of_column[column].end(), found.begin(), found.end());
    }
  });
  for (std::size_t ray = 0; ray < fan.size(); ++ray) {
    all.behind.offset[ray + 1] += all.behind.offset[ray];
  }
  for (auto& column : of_column) {
    for (const RefractedHit& refracted : column) {
      all.behind.hits.push_back(refracted.hit);
      all.paths.push_back(refracted.path);
    }
    column = {};
  }
  return all;
}

}  // namespace ensonify
