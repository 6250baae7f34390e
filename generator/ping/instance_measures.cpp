#include "ping/instance_measures.h"

#include <algorithm>
#include <limits>
#include <variant>

#include "trace/truncation.h"

namespace ensonify {
namespace {

bool is_always_ground(const Shape& shape) {
  const auto* mesh = std::get_if<MeshShape>(&shape);
  return is_room(shape) || std::holds_alternative<PlaneShape>(shape) ||
         (mesh != nullptr && mesh->ground);
}

}  // namespace

MeasuredInstances measured_instances(const World& world) {
  MeasuredInstances measured;
  measured.size_m.resize(world.instances.size() + 1);
  for (const WorldObject& object : world.objects) {
    measured.surface_m.push_back(surface_samples(object.shape));
    double& size = measured.size_m[object.instance];
    if (const auto& box = world.instances[object.instance - 1].box) {
      size = std::max({box->size_m.x, box->size_m.y, box->size_m.z});
    }
    if (is_always_ground(object.shape)) size = std::numeric_limits<double>::infinity();
  }
  return measured;
}

std::vector<InstanceMeasures> instance_measures(const MeasuredPing& ping) {
  std::vector<InstanceMeasures> measures(ping.instances.size_m.size());
  const std::vector<double> contrast =
      contrasts_db(ping.polar, ping.clean_power_pa2, ping.polar_instances, ping.instances.size_m);
  std::vector<bool> is_seen(measures.size());
  for (std::size_t i = 0; i < contrast.size(); ++i) {
    measures[ping.polar_instances[i].instance].contrast_db = contrast[i];
    is_seen[ping.polar_instances[i].instance] = true;
  }
  const std::vector<WorldObject>& objects = ping.session.world.objects;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (!is_seen[objects[i].instance]) continue;
    measures[objects[i].instance].truncated =
        truncated_share(ping.instances.surface_m[i], ping.object_in_world[i], ping.sonar_in_world,
                        ping.session.sonar);
  }
  return measures;
}

}  // namespace ensonify
