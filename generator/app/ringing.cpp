#include "app/ringing.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "acoustics/elastic_sphere.h"

namespace ensonify {
namespace {

ElasticSphere sphere_of(const RingingSphereSpec& spec, const Water& water) {
  ElasticSphere sphere{spec.radius_m, spec.metal ? properties(*spec.metal) : spec.material,
                       spec.wall_m.value_or(spec.radius_m)};
  if (sphere.is_solid()) return sphere;
  sphere.filling = kAir;
  if (spec.filling == ShellFilling::water) {
    sphere.filling = {water.density_kg_m3, water.sound_speed_m_s};
  }
  return sphere;
}

}  // namespace

void ring_targets(const Scenario& scenario, const Sonar& sonar, const Water& water, World& world) {
  std::vector<std::pair<ElasticSphere, SphereTaps>> known;
  for (std::size_t i = 0; i < world.point_targets.size(); ++i) {
    const std::optional<RingingSphereSpec>& spec = scenario.point_targets[i].sphere;
    if (!spec) continue;
    const ElasticSphere sphere = sphere_of(*spec, water);
    auto same = std::find_if(known.begin(), known.end(),
                             [&](const auto& entry) { return entry.first == sphere; });
    if (same == known.end()) {
      known.emplace_back(sphere,
                         sphere_taps(sphere, water, sonar.frequency_hz, sonar.bandwidth_hz));
      same = known.end() - 1;
    }
    PointTarget& target = world.point_targets[i];
    target.taps = same->second.taps;
    target.missing = same->second.error;
    Instance& instance = world.instances[target.instance - 1];
    instance.sphere = sphere;
    instance.target_strength_db =
        20 * std::log10(std::abs(sphere_backscatter_m(sphere, water, sonar.frequency_hz)));
    target.target_strength_db = instance.target_strength_db;
  }
}

}  // namespace ensonify
