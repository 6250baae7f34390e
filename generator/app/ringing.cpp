#include "app/ringing.h"

#include <algorithm>
#include <cmath>
#include <map>
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

// The responses of bodies, computed once for equal ones.
class Responses {
 public:
  Responses(const Sonar& sonar, const Water& water) : sonar_(sonar), water_(water) {}

  Ringing of(const ElasticBody& body, bool is_cylinder) {
    for (const Known& known : known_) {
      if (known.body == body && known.is_cylinder == is_cylinder) return known.ringing;
    }
    const auto compute = is_cylinder ? cylinder_taps : sphere_taps;
    ElasticTaps taps = compute(body, water_, sonar_.frequency_hz, sonar_.bandwidth_hz);
    known_.push_back({body, is_cylinder, {std::move(taps.taps), taps.error}});
    return known_.back().ringing;
  }

 private:
  struct Known {
    ElasticBody body;
    bool is_cylinder;
    Ringing ringing;
  };
  const Sonar& sonar_;
  const Water& water_;
  std::vector<Known> known_;
};

}  // namespace

void ring_bodies(const Scenario& scenario, const Sonar& sonar, const Water& water, World& world) {
  Responses responses(sonar, water);
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const std::optional<ElasticSpec>& spec = scenario.objects[i].elastic;
    if (!spec) continue;
    WorldObject& object = world.objects[i];
    const auto* cylinder = std::get_if<CylinderShape>(&object.shape);
    const double radius_m =
        cylinder != nullptr ? cylinder->radius_m : std::get<SphereShape>(object.shape).radius_m;
    const ElasticBody body = body_of(*spec, radius_m, water);
    object.ringing = responses.of(body, cylinder != nullptr);
    world.instances[object.instance - 1].elastic = body;
  }
  for (std::size_t i = 0; i < world.point_targets.size(); ++i) {
    const std::optional<RingingSphereSpec>& spec = scenario.point_targets[i].sphere;
    if (!spec) continue;
    const ElasticBody body = body_of(*spec, spec->radius_m, water);
    PointTarget& target = world.point_targets[i];
    target.ringing = responses.of(body, false);
    Instance& instance = world.instances[target.instance - 1];
    instance.elastic = body;
    instance.target_strength_db =
        20 * std::log10(std::abs(sphere_backscatter_m(body, water, sonar.frequency_hz)));
    target.target_strength_db = instance.target_strength_db;
  }
}

}  // namespace ensonify
