#include "trace/scatter.h"

#include <algorithm>
#include <cmath>

#include "acoustics/scattering.h"
#include "core/error.h"
#include "trace/echo.h"

namespace ensonify {
namespace {

// A target is hidden by what stands before it, not by the surface it lies on.
constexpr double kOnSurface = 1e-6;

// A constant amplitude without a random part is one; NaN and infinity are not.
bool is_an_echo(const ScattererMoments& moments) {
  return std::isfinite(moments.mean_m) && std::isfinite(moments.variance_m2) &&
         moments.variance_m2 >= 0 && (moments.mean_m > 0 || moments.variance_m2 > 0);
}

}  // namespace

SurfaceScattering make_surface_scattering(const Sonar& sonar, const Water& water,
                                          const World& world) {
  SurfaceScattering scattering{sonar, water, {}};
  scattering.material.resize(world.instances.size() + 1);
  for (const WorldObject& object : world.objects) {
    scattering.material[object.instance] = object.material;
  }
  return scattering;
}

std::vector<Scatterer> surface_scatterers(const Fan& fan, std::span<const Hit> hits,
                                          const SurfaceScattering& scattering) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  std::vector<Scatterer> scatterers;
  scatterers.reserve(hits.size());
  for (std::size_t ray = 0; ray < hits.size(); ++ray) {
    const Hit& hit = hits[ray];
    if (hit.instance == 0 || !in_range(hit.range_m, scattering.sonar)) continue;
    if (!(hit.cos_incidence >= 0 && hit.cos_incidence <= 1)) continue;
    const std::size_t column = ray / fan.rays_elevation;
    const std::size_t e = ray % fan.rays_elevation;
    ENSONIFY_ASSERT(hit.instance < scattering.material.size());
    const ScattererMoments moments =
        scatterer_moments(scattering.material[hit.instance], hit.reflectivity, hit.cos_incidence,
                          hit.range_m, fan.solid_angle_sr[e]);
    if (!is_an_echo(moments)) continue;
    Scatterer s =
        echo_from(hit.range_m, fan.azimuth_rad[column], fan.elevation_rad[e],
                  static_cast<int>(column / fan.rays_azimuth), scattering.sonar, scattering.water);
    s.standard_deviation = static_cast<float>(std::sqrt(moments.variance_m2));
    s.mean = static_cast<float>(moments.mean_m);
    s.cos_incidence = hit.cos_incidence;
    s.key = ray;
    s.instance = hit.instance;
    scatterers.push_back(s);
  }
  return scatterers;
}

std::vector<Scatterer> point_target_scatterers(const World& world, const Tracer& tracer,
                                               const Pose& sonar_in_world, const Sonar& sonar,
                                               const Water& water) {
  std::vector<Scatterer> scatterers;
  for (const PointTarget& target : world.point_targets) {
    const Vec3 p = inverse_transform_point(sonar_in_world, target.position_m);
    const double range = length(p);
    if (!in_range(range, sonar)) continue;
    const double azimuth = std::atan2(p.y, p.x);
    const double elevation = std::asin(std::clamp(p.z / range, -1.0, 1.0));
    const std::optional<int> beam = sector_of(sonar, azimuth);
    if (!beam || std::abs(elevation) > sonar.elevation_fan_rad / 2) continue;
    const Vec3 way = target.position_m - sonar_in_world.position_m;
    const Hit before = tracer.first_hit({sonar_in_world.position_m, normalized(way)}, range);
    if (before.instance != 0 && before.range_m < range * (1 - kOnSurface)) continue;
    Scatterer s = echo_from(range, azimuth, elevation, *beam, sonar, water);
    s.mean = static_cast<float>(target_amplitude_m(target.target_strength_db));
    s.cos_incidence = 1;
    // Beyond every ray's key; a target is not drawn, its key only settles ties.
    s.key = (std::uint64_t{1} << 63) | target.instance;
    s.instance = target.instance;
    scatterers.push_back(s);
  }
  return scatterers;
}

}  // namespace ensonify
