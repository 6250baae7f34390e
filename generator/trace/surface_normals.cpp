#include "trace/surface_normals.h"

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

}  // namespace ensonify
