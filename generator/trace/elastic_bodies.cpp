#include "trace/elastic_bodies.h"

#include <cmath>
#include <optional>

#include "trace/echo.h"

namespace ensonify {
namespace {

bool is_seen(const PlacedWorld& placed, Vec3 place_m, std::uint32_t instance) {
  const Vec3 way = place_m - placed.sonar_in_world.position_m;
  const Hit hit =
      placed.tracer.first_hit({placed.sonar_in_world.position_m, normalized(way)}, length(way));
  return hit.instance == instance;
}

void add_body(const PlacedWorld& placed, std::size_t index, const Sonar& sonar, const Water& water,
              std::vector<Scatterer>& scatterers) {
  const WorldObject& object = placed.world.objects[index];
  const Pose& pose = placed.object_in_world[index];
  Line axis{pose.position_m, {}};
  double per_piece = 1;
  int count = 1;
  if (const auto* cylinder = std::get_if<CylinderShape>(&object.shape)) {
    axis.half_m = rotate(pose.rotation, {0, 0, cylinder->half_height_m});
    count = pieces_of(axis, placed.sonar_in_world.position_m, sonar, water);
    per_piece = axis.length_m() / count;
  }
  for (int i = 0; i < count; ++i) {
    const Vec3 place = piece_middle_m(axis, i, count);
    std::optional<Scatterer> s = echo_at(place, placed.sonar_in_world, sonar, water);
    if (!s || !is_seen(placed, place, object.instance)) continue;
    s->cos_incidence = 1;
    s->instance = object.instance;
    s->key = elastic_key(object.instance, i);
    for (std::size_t tap = 0; tap < object.ringing.taps.size(); ++tap) {
      add_tap(*s, object.ringing.taps[tap], tap, scatterers);
      scatterers.back().mean *= static_cast<float>(per_piece);
    }
  }
}

}  // namespace

std::vector<Scatterer> elastic_scatterers(const PlacedWorld& placed, const Sonar& sonar,
                                          const Water& water, const Workers& workers) {
  const std::vector<WorldObject>& objects = placed.world.objects;
  std::vector<std::vector<Scatterer>> by_object(objects.size());
  workers.for_each(objects.size(), [&](std::size_t i) {
    if (!objects[i].ringing.taps.empty()) add_body(placed, i, sonar, water, by_object[i]);
  });
  std::vector<Scatterer> all;
  append(by_object, all);
  return all;
}

}  // namespace ensonify
