#include "trace/scatter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "acoustics/pattern.h"
#include "acoustics/scattering.h"
#include "core/error.h"
#include "trace/echo.h"
#include "trace/sector_lists.h"

namespace ensonify {
namespace {

// What the echoes of point targets and fish share.
struct PointEchoes {
  const Tracer& tracer;
  const Pose& pose;
  const Sonar& sonar;
  const Water& water;
  const std::vector<HiddenTarget>* hidden = nullptr;  // null: hidden ones are not wanted

  std::optional<RefractedRays> refracted;  // if the sound speed varies

  // Returns none if the point is outside the fan or its ranges. `hidden_by` is the result of
  // what_hides.
  std::optional<Scatterer> at(Vec3 position_m, double target_strength_db,
                              std::optional<std::uint32_t>& hidden_by) const {
    std::optional<Scatterer> s =
        refracted ? refracted_to(position_m, hidden_by) : straight_to(position_m, hidden_by);
    if (!s) return std::nullopt;
    s->mean = static_cast<float>(target_amplitude_m(target_strength_db));
    s->cos_incidence = 1;
    return s;
  }

  std::optional<Scatterer> straight_to(Vec3 position_m,
                                       std::optional<std::uint32_t>& hidden_by) const {
    std::optional<Scatterer> s = echo_at(position_m, pose, sonar, water);
    if (!s) return std::nullopt;
    const Vec3 way = position_m - pose.position_m;
    hidden_by = what_hides({pose.position_m, normalized(way)}, length(s->position_m));
    return s;
  }

  std::optional<Scatterer> refracted_to(Vec3 position_m,
                                        std::optional<std::uint32_t>& hidden_by) const {
    const Vec3 way = position_m - pose.position_m;
    const double level = std::hypot(way.x, way.y);
    if (level == 0 && way.z == 0) return std::nullopt;
    const auto ray = find_eigenray(refracted->layers, pose.position_m.z, level, position_m.z);
    if (!ray) return std::nullopt;
    const double range = water.sound_speed_m_s * ray->end.time_s;
    if (!in_range(range, sonar)) return std::nullopt;
    const double ahead = level > 0 ? ray->cos_phi / level : 0;
    const Vec3 direction{ahead * way.x, ahead * way.y, ray->sin_phi};
    const Vec3 d = rotate(conjugate(pose.rotation), direction);
    const double azimuth = std::atan2(d.y, d.x), elevation = std::asin(std::clamp(d.z, -1.0, 1.0));
    const std::optional<int> beam = sector_of(sonar, azimuth);
    if (!beam || std::abs(elevation) > sonar.elevation_fan_rad / 2) return std::nullopt;
    hidden_by = what_hides_bent(direction, ray->end);
    Scatterer s = echo_from(range, azimuth, elevation, *beam, sonar, water);
    set_refracted(path_to(*refracted, direction, ray->end),
                  echo_direction(azimuth, elevation, sonar), water, s);
    return s;
  }

  std::optional<std::uint32_t> what_hides_bent(Vec3 direction, const RayPoint& end) const {
    const double before_m = end.path_m * (1 - kOnSurface);
    const auto first = first_refracted_hit(*refracted, direction, end.time_s);
    if (!first || first->path.length_m >= before_m) return std::nullopt;
    if (hidden == nullptr) return 0;
    for (const RefractedHit& hit : refracted_hits_along(*refracted, direction, end.time_s)) {
      if (hit.hit.instance != first->hit.instance && hit.path.length_m < before_m) return 0;
    }
    return first->hit.instance;
  }

  // The instance that hides a point. None if nothing hides it; 0 if several instances do, or if the
  // instance is not wanted.
  std::optional<std::uint32_t> what_hides(const Ray& ray, double range_m) const {
    const double before_m = range_m * (1 - kOnSurface);
    const Hit first = tracer.first_hit(ray, range_m);
    if (first.instance == 0 || first.range_m >= before_m) return std::nullopt;
    if (hidden == nullptr) return 0;
    for (const Hit& hit : tracer.hits_along(ray, range_m)) {
      if (hit.instance != first.instance && hit.range_m < before_m) return 0;
    }
    return first.instance;
  }

  // Adds an echo to the audible ones or, if they are wanted, to the hidden ones.
  void sort_out(const Scatterer& s, std::optional<std::uint32_t> hidden_by,
                std::vector<Scatterer>& heard, std::vector<HiddenTarget>* not_heard) const {
    if (!hidden_by) {
      heard.push_back(s);
    } else if (not_heard != nullptr) {
      not_heard->push_back({s, *hidden_by});
    }
  }
};

PointEchoes point_echoes(const Tracer& tracer, const Pose& pose, const Sonar& sonar,
                         const Water& water, const std::vector<HiddenTarget>* hidden) {
  PointEchoes echoes{tracer, pose, sonar, water, hidden, {}};
  if (bends(water)) echoes.refracted.emplace(refracted_rays(tracer, pose, sonar, water));
  return echoes;
}

// Keys of hidden echoes: the hits of each ray in order, then the targets, with this bit.
constexpr std::uint64_t kTargetKey = std::uint64_t{1} << 63;

// How many rays, targets and fish lead to an instance, and how many of them meet another one first.
struct Meetings {
  std::uint64_t all = 0, behind = 0;
};

std::vector<double> occlusion_of(std::span<const Hit> hits, const HitsBehind& behind,
                                 const PointScatterers& points, const Sonar& sonar,
                                 std::size_t instances) {
  std::vector<Meetings> met(instances + 1);
  for (const Hit& hit : hits) {
    if (hit.instance != 0 && in_range(hit.range_m, sonar)) ++met[hit.instance].all;
  }
  const auto add_hidden = [&](std::uint32_t instance) {
    ++met[instance].all;
    ++met[instance].behind;
  };
  for (const Hit& hit : behind.hits) {
    if (in_range(hit.range_m, sonar)) add_hidden(hit.instance);
  }
  for (const Scatterer& s : points.heard) ++met[s.instance].all;
  for (const HiddenTarget& target : points.hidden) {
    if (!target.has_rays) add_hidden(target.scatterer.instance);
  }
  std::vector<double> occlusion;
  for (const Meetings& m : met) {
    occlusion.push_back(m.all == 0 ? std::numeric_limits<double>::quiet_NaN()
                                   : static_cast<double>(m.behind) / static_cast<double>(m.all));
  }
  return occlusion;
}

std::vector<Scatterer> scatterers_behind(const Fan& fan, const FanHitsBehind& all_behind,
                                         const SurfaceScattering& scattering,
                                         const Workers& workers) {
  const SurfaceEchoes echoes{fan, scattering};
  const HitsBehind& behind = all_behind.behind;
  const std::vector<RayPath>& paths = all_behind.paths;
  const std::size_t rays = fan.rays_per_beam();
  std::vector<std::vector<Scatterer>> of_beam(fan.beams);
  workers.for_each(fan.beams, [&](std::size_t beam) {
    ScattererMoments moments;
    for (std::uint32_t i = 0; i < rays; ++i) {
      std::uint64_t layer = 0;
      const std::uint32_t first = behind.offset[beam * rays + i];
      for (const Hit& hit : behind.of_ray(beam * rays + i)) {
        const RayPath* path = paths.empty() ? nullptr : &paths[first + layer];
        const std::uint64_t key = (beam * rays + i) * kMostLayers + layer++;
        if (!echoes.moments(hit, beam, i % fan.rays_elevation, moments, path)) continue;
        Scatterer& s = of_beam[beam].emplace_back();
        echoes.set(static_cast<std::uint32_t>(beam), i, hit, moments, s, path);
        s.key = key;
      }
    }
  });
  std::vector<Scatterer> all;
  append(of_beam, all);
  return all;
}

}  // namespace

std::vector<Scatterer> surface_scatterers(const Fan& fan, std::span<const Hit> hits,
                                          const SurfaceScattering& scattering) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  const SurfaceEchoes echoes{fan, scattering};
  std::vector<Scatterer> scatterers;
  scatterers.reserve(hits.size());
  ScattererMoments moments;
  const std::size_t rays = fan.rays_per_beam();
  for (std::size_t ray = 0; ray < hits.size(); ++ray) {
    if (!echoes.moments(hits[ray], ray / rays, ray % fan.rays_elevation, moments)) continue;
    echoes.set(static_cast<std::uint32_t>(ray / rays), static_cast<std::uint32_t>(ray % rays),
               hits[ray], moments, scatterers.emplace_back());
  }
  return scatterers;
}

ScattererList surface_scatterer_list(const Fan& fan, std::span<const Hit> hits,
                                     const SurfaceScattering& scattering, const Workers& workers,
                                     std::span<const RayPath> paths) {
  ENSONIFY_ASSERT(hits.size() == fan.size() && (paths.empty() || paths.size() == hits.size()));
  const SurfaceEchoes echoes{fan, scattering};
  const auto path = [&](std::size_t ray) { return paths.empty() ? nullptr : &paths[ray]; };
  const std::size_t rays = fan.rays_per_beam();
  std::vector<std::uint32_t> most(static_cast<std::size_t>(fan.beams), 0);
  for (std::size_t ray = 0; ray < hits.size(); ++ray) {
    most[ray / rays] += is_usable(hits[ray], scattering.sonar);
  }
  return list_of_sectors<SectorWork>(
      most, workers, [&](std::size_t beam, SectorWork& work, std::vector<Scatterer>& scatterers) {
        work.order.clear();
        work.moments.resize(rays);
        std::size_t ray = beam * rays;
        std::uint32_t i = 0;
        for (int a = 0; a < fan.rays_azimuth; ++a) {
          for (int e = 0; e < fan.rays_elevation; ++e, ++ray, ++i) {
            if (!echoes.moments(hits[ray], beam, e, work.moments[i], path(ray))) continue;
            const double delay =
                two_way_delay_s(hits[ray].range_m, scattering.water.sound_speed_m_s);
            work.order.push_back({delay, ray, i});
          }
        }
        sort_keys(work.order);
        for (const SortKey& k : work.order) {
          echoes.set(static_cast<std::uint32_t>(beam), k.index, hits[beam * rays + k.index],
                     work.moments[k.index], scatterers.emplace_back(), path(beam * rays + k.index));
        }
      });
}

std::vector<Scatterer> point_target_scatterers(const World& world, const Tracer& tracer,
                                               const Pose& sonar_in_world, const Sonar& sonar,
                                               const Water& water,
                                               std::vector<HiddenTarget>* hidden) {
  const PointEchoes echoes = point_echoes(tracer, sonar_in_world, sonar, water, hidden);
  std::vector<Scatterer> scatterers;
  for (const PointTarget& target : world.point_targets) {
    std::optional<std::uint32_t> hidden_by;
    std::optional<Scatterer> s = echoes.at(target.position_m, target.target_strength_db, hidden_by);
    if (!s) continue;
    s->key = point_target_key(target.instance);
    s->instance = target.instance;
    if (target.ringing.taps.empty()) {
      echoes.sort_out(*s, hidden_by, scatterers, hidden);
      continue;
    }
    std::vector<Scatterer> taps;
    for (std::size_t i = 0; i < target.ringing.taps.size(); ++i) {
      add_tap(*s, target.ringing.taps[i], i, taps);
    }
    for (const Scatterer& tap : taps) echoes.sort_out(tap, hidden_by, scatterers, hidden);
  }
  return scatterers;
}

std::vector<Scatterer> school_scatterers(const World& world, const Tracer& tracer,
                                         const Pose& sonar_in_world, const Sonar& sonar,
                                         const Water& water, const Workers& workers,
                                         std::vector<HiddenTarget>* hidden) {
  const PointEchoes echoes = point_echoes(tracer, sonar_in_world, sonar, water, hidden);
  std::vector<Scatterer> scatterers;
  for (const School& school : world.schools) {
    constexpr std::size_t kBlock = 256;
    const std::size_t fish = school.fish_m.size(), blocks = (fish + kBlock - 1) / kBlock;
    std::vector<std::vector<Scatterer>> found(blocks);
    std::vector<std::vector<HiddenTarget>> not_heard(blocks);
    workers.for_each(blocks, [&](std::size_t block) {
      for (std::size_t i = block * kBlock; i < std::min((block + 1) * kBlock, fish); ++i) {
        std::optional<std::uint32_t> hidden_by;
        std::optional<Scatterer> s =
            echoes.at(school.fish_m[i], school.target_strength_db, hidden_by);
        if (!s) continue;
        s->key = fish_key(school.instance, i);
        s->instance = school.instance;
        echoes.sort_out(*s, hidden_by, found[block], hidden ? &not_heard[block] : nullptr);
      }
    });
    append(found, scatterers);
    if (hidden == nullptr) continue;
    for (const auto& part : not_heard) hidden->insert(hidden->end(), part.begin(), part.end());
  }
  return scatterers;
}

HiddenEchoes hidden_echoes(const Fan& fan, std::span<const Hit> hits, const FanHitsBehind& behind,
                           const PointScatterers& points, const SurfaceScattering& scattering,
                           std::size_t instances, const Workers& workers) {
  std::vector<Scatterer> all = scatterers_behind(fan, behind, scattering, workers);
  for (std::size_t i = 0; i < points.hidden.size(); ++i) {
    all.push_back(points.hidden[i].scatterer);
    all.back().key = kTargetKey | i;
  }
  HiddenEchoes hidden;
  hidden.list = sorted_by_beam_and_delay(all, fan.beams, workers);
  for (const Scatterer& s : hidden.list.items) {
    if ((s.key & kTargetKey) != 0) {
      hidden.occluder.push_back(points.hidden[s.key & ~kTargetKey].occluder);
    } else {
      const bool next = s.key % kMostLayers == 0;
      hidden.occluder.push_back(next ? hits[s.key / kMostLayers].instance : 0);
    }
  }
  hidden.occlusion = occlusion_of(hits, behind.behind, points, scattering.sonar, instances);
  return hidden;
}

}  // namespace ensonify
