#include "trace/scatter.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "acoustics/scattering.h"
#include "core/error.h"
#include "trace/surface_echoes.h"

namespace ensonify {
namespace {

// What sorting a sector needs, kept from one to the next.
struct SectorWork {
  std::vector<SortKey> order;
  std::vector<ScattererMoments> moments;
};

// Calls body(beam, work) for all beams, those of a block one after the other.
template <class Body>
void for_each_block(std::size_t beams, const Workers& workers, const Body& body) {
  constexpr std::size_t kBlock = 16;
  workers.for_each((beams + kBlock - 1) / kBlock, [&](std::size_t block) {
    SectorWork work;
    const std::size_t end = std::min((block + 1) * kBlock, beams);
    for (std::size_t beam = block * kBlock; beam < end; ++beam) body(beam, work);
  });
}

// Those of beam j are the first count[j] from room[j] on: moves all together.
void close_up(const std::vector<std::uint32_t>& room, const std::vector<std::uint32_t>& count,
              ScattererList& list) {
  list.beam_offset.assign(1, 0);
  for (std::size_t j = 0; j < count.size(); ++j) {
    const auto first = list.items.begin() + room[j];
    const std::uint32_t offset = list.beam_offset.back();
    if (offset != room[j]) std::copy(first, first + count[j], list.items.begin() + offset);
    list.beam_offset.push_back(offset + count[j]);
  }
  list.items.resize(list.beam_offset.back());
}

// What the echoes of point reflectors share.
struct PointEchoes {
  const Tracer& tracer;
  const Pose& pose;
  const Sonar& sonar;
  const Water& water;
  const std::vector<HiddenTarget>* hidden = nullptr;  // where hidden ones are asked for

  std::optional<BentRays> bent;  // where the water bends rays

  // None where the point is outside the fan and its ranges. With what hides it told, where it does.
  std::optional<Scatterer> at(Vec3 position_m, double target_strength_db,
                              std::optional<std::uint32_t>& hidden_by) const {
    std::optional<Scatterer> s =
        bent ? bent_to(position_m, hidden_by) : straight_to(position_m, hidden_by);
    if (!s) return std::nullopt;
    s->mean = static_cast<float>(target_amplitude_m(target_strength_db));
    s->cos_incidence = 1;
    return s;
  }

  std::optional<Scatterer> straight_to(Vec3 position_m,
                                       std::optional<std::uint32_t>& hidden_by) const {
    const Vec3 p = inverse_transform_point(pose, position_m);
    const double range = length(p);
    if (!in_range(range, sonar)) return std::nullopt;
    const double azimuth = std::atan2(p.y, p.x);
    const double elevation = std::asin(std::clamp(p.z / range, -1.0, 1.0));
    const std::optional<int> beam = sector_of(sonar, azimuth);
    if (!beam || std::abs(elevation) > sonar.elevation_fan_rad / 2) return std::nullopt;
    const Vec3 way = position_m - pose.position_m;
    hidden_by = what_hides({pose.position_m, normalized(way)}, range);
    return echo_from(range, azimuth, elevation, *beam, sonar, water);
  }

  std::optional<Scatterer> bent_to(Vec3 position_m, std::optional<std::uint32_t>& hidden_by) const {
    const Vec3 way = position_m - pose.position_m;
    const double level = std::hypot(way.x, way.y);
    if (level == 0 && way.z == 0) return std::nullopt;
    const auto ray = find_eigenray(bent->layers, pose.position_m.z, level, position_m.z);
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
    set_bent(path_to(*bent, direction, ray->end), echo_direction(azimuth, elevation, sonar), water,
             s);
    return s;
  }

  std::optional<std::uint32_t> what_hides_bent(Vec3 direction, const RayPoint& end) const {
    const double before_m = end.path_m * (1 - kOnSurface);
    const auto first = first_bent_hit(*bent, direction, end.time_s);
    if (!first || first->path.length_m >= before_m) return std::nullopt;
    if (hidden == nullptr) return 0;
    for (const BentHit& hit : bent_hits_along(*bent, direction, end.time_s)) {
      if (hit.hit.instance != first->hit.instance && hit.path.length_m < before_m) return 0;
    }
    return first->hit.instance;
  }

  // None: nothing. 0: more than one instance, or it is not asked for.
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

  // The echo goes where it belongs.
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
  if (bends(water)) echoes.bent.emplace(bent_rays(tracer, pose, sonar, water));
  return echoes;
}

}  // namespace

SurfaceScattering make_surface_scattering(const Sonar& sonar, const Water& water,
                                          const World& world) {
  SurfaceScattering scattering{sonar, water, {}, {}};
  scattering.material.resize(world.instances.size() + 1);
  for (const WorldObject& object : world.objects) {
    scattering.material[object.instance] = object.material;
    if (object.parts.materials.empty()) continue;
    scattering.part_material.resize(scattering.material.size());
    scattering.part_material[object.instance] = object.parts.materials;
  }
  return scattering;
}

std::vector<Scatterer> surface_scatterers(const Fan& fan, std::span<const Hit> hits,
                                          const SurfaceScattering& scattering) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  const SurfaceEchoes echoes{fan, scattering};
  std::vector<Scatterer> scatterers;
  scatterers.reserve(hits.size());
  ScattererMoments moments;
  const std::size_t rays = fan.rays_per_beam();
  for (std::size_t ray = 0; ray < hits.size(); ++ray) {
    if (!echoes.moments(hits[ray], ray % fan.rays_elevation, moments)) continue;
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
  const std::size_t beams = fan.beams, rays = fan.rays_per_beam();
  // Room for every usable hit. Few of them make no echo; their room is closed up at the end.
  std::vector<std::uint32_t> room(beams + 1, 0), count(beams, 0);
  for_each_block(beams, workers, [&](std::size_t beam, auto&) {
    for (const Hit& hit : hits.subspan(beam * rays, rays)) {
      room[beam + 1] += is_usable(hit, scattering.sonar);
    }
  });
  std::partial_sum(room.begin(), room.end(), room.begin());
  ScattererList list;
  list.items.resize(room.back());
  for_each_block(beams, workers, [&](std::size_t beam, SectorWork& work) {
    work.order.clear();
    work.moments.resize(rays);
    std::size_t ray = beam * rays;
    std::uint32_t i = 0;
    for (int a = 0; a < fan.rays_azimuth; ++a) {
      for (int e = 0; e < fan.rays_elevation; ++e, ++ray, ++i) {
        if (!echoes.moments(hits[ray], e, work.moments[i], path(ray))) continue;
        const double delay = two_way_delay_s(hits[ray].range_m, scattering.water.sound_speed_m_s);
        work.order.push_back({delay, ray, i});
      }
    }
    sort_keys(work.order);
    Scatterer* next = list.items.data() + room[beam];
    for (const SortKey& k : work.order) {
      echoes.set(static_cast<std::uint32_t>(beam), k.index, hits[beam * rays + k.index],
                 work.moments[k.index], *next++, path(beam * rays + k.index));
    }
    count[beam] = static_cast<std::uint32_t>(work.order.size());
  });
  close_up(room, count, list);
  return list;
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
    echoes.sort_out(*s, hidden_by, scatterers, hidden);
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
    for (const auto& part : found) scatterers.insert(scatterers.end(), part.begin(), part.end());
    if (hidden == nullptr) continue;
    for (const auto& part : not_heard) hidden->insert(hidden->end(), part.begin(), part.end());
  }
  return scatterers;
}

}  // namespace ensonify
