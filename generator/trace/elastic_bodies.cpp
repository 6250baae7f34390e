#include <cmath>
#include <optional>

#include "trace/echo.h"
#include "trace/scatter.h"

namespace ensonify {
namespace {

// Whether the ray to a place meets its object first, and otherwise the only instance that hides it;
// 0: several do.
struct Sight {
  bool is_seen = false;
  std::uint32_t occluder = 0;
};

Sight sight_of(const PlacedWorld& placed, Vec3 place_m, std::uint32_t instance,
               bool wants_occluder) {
  const Vec3 eye = placed.sonar_in_world.position_m, way = place_m - eye;
  const Ray ray{eye, normalized(way)};
  const Hit first = placed.tracer.first_hit(ray, length(way));
  if (first.instance == instance) return {true, 0};
  if (!wants_occluder) return {};
  for (const Hit& hit : placed.tracer.hits_along(ray, length(way))) {
    if (hit.instance == instance) break;
    if (hit.instance != first.instance) return {};
  }
  return {false, first.instance};
}

// Those of one object.
struct BodyEchoes {
  std::vector<Scatterer> heard;
  std::vector<HiddenTarget> hidden;
};

void add_body(const PlacedWorld& placed, std::size_t index, const Sonar& sonar, const Water& water,
              bool wants_hidden, BodyEchoes& echoes) {
  const WorldObject& object = placed.world.objects[index];
  const Pose& pose = placed.object_in_world[index];
  const Vec3 eye = placed.sonar_in_world.position_m;
  Line axis{pose.position_m, {}};
  const auto* cylinder = std::get_if<CylinderShape>(&object.shape);
  if (cylinder != nullptr) axis.half_m = rotate(pose.rotation, {0, 0, cylinder->half_height_m});
  const auto line = within_range(axis, eye, sonar.range_max_m);
  if (!line) return;
  const int count = pieces_of(*line, eye, sonar, water);
  const double piece_m = line->length_m() / count;
  const double wavelength = water.sound_speed_m_s / sonar.frequency_hz;
  for (int i = 0; i < count; ++i) {
    const Vec3 place = piece_middle_m(*line, i, count);
    std::optional<Scatterer> s = echo_at(place, placed.sonar_in_world, sonar, water);
    if (!s) continue;
    double size = 1;
    if (cylinder != nullptr) {
      const double cos_beta = dot(normalized(line->half_m), normalized(place - eye));
      size = piece_m * sinc(2 * piece_m * cos_beta / wavelength);
    }
    s->cos_incidence = 1;
    s->instance = object.instance;
    s->key = elastic_key(object.instance, i);
    const Sight sight = sight_of(placed, place, object.instance, wants_hidden);
    std::vector<Scatterer> taps;
    for (std::size_t tap = 0; tap < object.ringing.taps.size(); ++tap) {
      add_tap(*s, object.ringing.taps[tap], tap, taps);
      taps.back().mean *= static_cast<float>(size);
    }
    for (const Scatterer& tap : taps) {
      if (sight.is_seen) {
        echoes.heard.push_back(tap);
      } else if (wants_hidden) {
        echoes.hidden.push_back({tap, sight.occluder, true});
      }
    }
  }
}

}  // namespace

std::vector<Scatterer> elastic_scatterers(const PlacedWorld& placed, const Sonar& sonar,
                                          const Water& water, const Workers& workers,
                                          std::vector<HiddenTarget>* hidden) {
  const std::vector<WorldObject>& objects = placed.world.objects;
  std::vector<BodyEchoes> by_object(objects.size());
  workers.for_each(objects.size(), [&](std::size_t i) {
    if (objects[i].ringing.taps.empty()) return;
    add_body(placed, i, sonar, water, hidden != nullptr, by_object[i]);
  });
  std::vector<Scatterer> all;
  for (const BodyEchoes& echoes : by_object) {
    all.insert(all.end(), echoes.heard.begin(), echoes.heard.end());
    if (hidden == nullptr) continue;
    hidden->insert(hidden->end(), echoes.hidden.begin(), echoes.hidden.end());
  }
  return all;
}

}  // namespace ensonify
