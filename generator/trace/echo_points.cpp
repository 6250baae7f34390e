#include "trace/echo_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"

namespace ensonify {
namespace {

// A hit within this part of the range is the same point.
constexpr double kSamePlace = 1e-5;
// How far before a point the second ray starts: part of the range, and least distance.
constexpr double kApproach = 1e-3, kLeastApproach_m = 1e-3;

// Traces only the last piece of the straight line: refracted sound may pass an obstacle that blocks
// the line.
Hit hit_from_nearby(const Tracer& tracer, Vec3 place_m, Vec3 direction, double range_m,
                    std::uint32_t instance) {
  const double before_m = std::max(kApproach * range_m, kLeastApproach_m);
  const Hit hit = tracer.first_hit({place_m - before_m * direction, direction}, 2 * before_m);
  const bool same = hit.instance == instance && std::abs(hit.range_m - before_m) <= 0.1 * before_m;
  return same ? hit : Hit{};
}

}  // namespace

void surface_normals(const Tracer& tracer, const Pose& sonar_in_world, const ScattererList& list,
                     std::span<const std::uint32_t> which, std::span<Vec3> normals) {
  ENSONIFY_ASSERT(which.size() == normals.size());
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<Vec3> directions;
  std::vector<Hit> hits(which.size());
  double farthest_m = 0;
  for (const std::uint32_t item : which) {
    const Vec3 place = list.items[item].position_m;
    directions.push_back(normalized(rotate(sonar_in_world.rotation, place)));
    farthest_m = std::max(farthest_m, length(place));
  }
  tracer.first_hits(sonar_in_world.position_m, directions, farthest_m * (1 + kApproach), hits);
  for (std::size_t i = 0; i < which.size(); ++i) {
    const Scatterer& s = list.items[which[i]];
    const double range_m = length(s.position_m);
    Hit hit = hits[i];
    if (hit.instance != s.instance || std::abs(hit.range_m - range_m) > kSamePlace * range_m) {
      hit = hit_from_nearby(tracer, transform_point(sonar_in_world, s.position_m), directions[i],
                            range_m, s.instance);
    }
    const double side = dot(hit.normal, directions[i]);
    normals[i] = hit.instance == 0 ? Vec3{kNone, kNone, kNone}
                                   : rotate(conjugate(sonar_in_world.rotation),
                                            side > 0 ? -hit.normal : hit.normal);
  }
}

namespace {

double azimuth_of(Vec3 in_sonar_m) { return std::atan2(in_sonar_m.y, in_sonar_m.x); }

bool in_fan(const Sonar& sonar, Vec3 in_sonar_m) {
  const double range_m = length(in_sonar_m);
  return range_m >= sonar.range_min_m && range_m <= sonar.range_max_m &&
         sector_of(sonar, azimuth_of(in_sonar_m)).has_value() &&
         std::abs(std::asin(in_sonar_m.z / range_m)) <= sonar.elevation_fan_rad / 2;
}

// Sample and beam of a point in the sonar's frame.
struct PolarPlace {
  double sample = 0, beam = 0;
};
PolarPlace place_of(const Sonar& sonar, Vec3 in_sonar_m, double sample_m) {
  return {length(in_sonar_m) / sample_m, beam_place(sonar, azimuth_of(in_sonar_m))};
}

}  // namespace

void see_points(const Viewpoint& view, std::span<const Vec3> points_m,
                std::span<PointSight> sights) {
  ENSONIFY_ASSERT(points_m.size() == sights.size());
  std::vector<std::size_t> inside;
  std::vector<Vec3> directions;
  double farthest_m = 0;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    sights[i] = {PointState::outside, 0};
    if (!in_fan(view.sonar, inverse_transform_point(view.sonar_in_world, points_m[i]))) continue;
    const Vec3 line = points_m[i] - view.sonar_in_world.position_m;
    inside.push_back(i);
    directions.push_back(normalized(line));
    farthest_m = std::max(farthest_m, length(line));
  }
  std::vector<Hit> hits(inside.size());
  view.tracer.first_hits(view.sonar_in_world.position_m, directions, farthest_m, hits);
  for (std::size_t k = 0; k < inside.size(); ++k) {
    const double range_m = length(points_m[inside[k]] - view.sonar_in_world.position_m);
    const bool hidden = hits[k].instance != 0 && hits[k].range_m < (1 - kSeenWithin) * range_m;
    sights[inside[k]] = {hidden ? PointState::hidden : PointState::seen,
                         static_cast<std::uint16_t>(hidden ? hits[k].instance : 0)};
  }
}

void point_motions(const PointMover& mover, const ScattererList& list,
                   std::span<const std::uint32_t> which, std::span<PointMotion> motions) {
  ENSONIFY_ASSERT(which.size() == motions.size());
  const Sonar& sonar = mover.there.sonar;
  const std::vector<WorldObject>& objects = mover.world.objects;
  const std::size_t with_points = objects.size() + mover.world.point_targets.size();
  std::vector<std::size_t> moved;
  std::vector<Vec3> there_m;
  for (std::size_t i = 0; i < which.size(); ++i) {
    motions[i] = {};
    const Scatterer& s = list.items[which[i]];
    const std::size_t index = s.instance - 1;
    if (s.instance == 0 || index >= with_points) continue;
    Vec3 point_m = transform_point(mover.sonar_here, s.position_m);
    if (index < objects.size()) {
      point_m = transform_point(mover.objects_there[index],
                                inverse_transform_point(mover.objects_here[index], point_m));
    }
    const PolarPlace here = place_of(sonar, s.position_m, mover.sample_m);
    const PolarPlace there = place_of(
        sonar, inverse_transform_point(mover.there.sonar_in_world, point_m), mover.sample_m);
    motions[i] = {here.sample, here.beam, there.sample, there.beam, PointState::none, 0};
    moved.push_back(i);
    there_m.push_back(point_m);
  }
  std::vector<PointSight> sights(moved.size());
  see_points(mover.there, there_m, sights);
  for (std::size_t k = 0; k < moved.size(); ++k) {
    PointMotion& motion = motions[moved[k]];
    motion.state = sights[k].state;
    motion.occluder = sights[k].occluder;
    const std::uint32_t own = list.items[which[moved[k]]].instance;
    if (motion.occluder == own && !objects[own - 1].ringing.taps.empty()) {
      motion.state = PointState::seen;
      motion.occluder = 0;
    }
  }
}

}  // namespace ensonify
