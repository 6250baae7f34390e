#include "ping/ringing.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "acoustics/elastic_body.h"

namespace ensonify {
namespace {

ElasticBody body_of(const ElasticSpec& spec, double radius_m, const Water& water) {
  ElasticBody body{radius_m, spec.metal ? properties(*spec.metal) : spec.material,
                   spec.wall_m.value_or(radius_m)};
  if (body.is_solid()) return body;
  body.filling = kAir;
  if (spec.filling == ShellFilling::water) {
    body.filling = {water.density_kg_m3, water.sound_speed_m_s};
  }
  return body;
}

}  // namespace

Ringing RingingLibrary::response(const ElasticBody& body, bool is_cylinder, const Sonar& sonar,
                                 const Water& water) {
  // Randomized bodies are all different, so only the last ones are kept.
  constexpr std::size_t kKept = 256;
  const std::lock_guard lock(mutex_);
  for (const Known& known : known_) {
    if (known.body == body && known.is_cylinder == is_cylinder &&
        known.frequency_hz == sonar.frequency_hz && known.bandwidth_hz == sonar.bandwidth_hz &&
        known.sound_speed_m_s == water.sound_speed_m_s &&
        known.density_kg_m3 == water.density_kg_m3) {
      return known.ringing;
    }
  }
  const auto compute = is_cylinder ? cylinder_taps : sphere_taps;
  ElasticTaps taps = compute(body, water, sonar.frequency_hz, sonar.bandwidth_hz);
  if (known_.size() >= kKept) known_.erase(known_.begin());
  known_.push_back({body, is_cylinder, sonar.frequency_hz, sonar.bandwidth_hz,
                    water.sound_speed_m_s, water.density_kg_m3,
                    {std::move(taps.taps), taps.error}});
  return known_.back().ringing;
}

void ring_bodies(const Scenario& scenario, const Sonar& sonar, const Water& water,
                 RingingLibrary* library, World& world) {
  RingingLibrary own;
  RingingLibrary& responses = library != nullptr ? *library : own;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const std::optional<ElasticSpec>& spec = scenario.objects[i].elastic;
    if (!spec) continue;
    WorldObject& object = world.objects[i];
    const auto* cylinder = std::get_if<CylinderShape>(&object.shape);
    const double radius_m =
        cylinder != nullptr ? cylinder->radius_m : std::get<SphereShape>(object.shape).radius_m;
    const ElasticBody body = body_of(*spec, radius_m, water);
    object.ringing = responses.response(body, cylinder != nullptr, sonar, water);
    world.instances[object.instance - 1].elastic = body;
  }
  for (std::size_t i = 0; i < world.point_targets.size(); ++i) {
    const std::optional<RingingSphereSpec>& spec = scenario.point_targets[i].sphere;
    if (!spec) continue;
    const ElasticBody body = body_of(*spec, spec->radius_m, water);
    PointTarget& target = world.point_targets[i];
    target.ringing = responses.response(body, false, sonar, water);
    Instance& instance = world.instances[target.instance - 1];
    instance.elastic = body;
    instance.target_strength_db =
        20 * std::log10(std::abs(sphere_backscatter_m(body, water, sonar.frequency_hz)));
    target.target_strength_db = instance.target_strength_db;
  }
}

}  // namespace ensonify
