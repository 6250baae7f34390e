#include "trace/hidden.h"

#include <limits>

#include "trace/surface_echoes.h"

namespace ensonify {
namespace {

// Keys of hidden echoes: a ray's hits one after the other, then the targets.
constexpr std::uint64_t kTargetKey = std::uint64_t{1} << 63;

// How many rays, targets and fish meet an instance, and before how many another one stands.
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
  for (const HiddenTarget& target : points.hidden) add_hidden(target.scatterer.instance);
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
        if (!echoes.moments(hit, i % fan.rays_elevation, moments, path)) continue;
        Scatterer& s = of_beam[beam].emplace_back();
        echoes.set(static_cast<std::uint32_t>(beam), i, hit, moments, s, path);
        s.key = key;
      }
    }
  });
  std::vector<Scatterer> all;
  all.reserve(behind.hits.size());
  for (auto& part : of_beam) {
    all.insert(all.end(), part.begin(), part.end());
    part = {};
  }
  return all;
}

}  // namespace

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
      hidden.caster.push_back(points.hidden[s.key & ~kTargetKey].caster);
    } else {
      const bool next = s.key % kMostLayers == 0;
      hidden.caster.push_back(next ? hits[s.key / kMostLayers].instance : 0);
    }
  }
  hidden.occlusion = occlusion_of(hits, behind.behind, points, scattering.sonar, instances);
  return hidden;
}

}  // namespace ensonify
