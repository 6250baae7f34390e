#include <algorithm>
#include <unordered_set>

#include <fmt/format.h>

#include "scenario/parse.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

void parse_area(Faults& faults, const Value& map, PlaceSpec& place) {
  const auto area = child(map, "area_m");
  if (!area) {
    add_fault(faults, map.place, path_of(map, "area_m"),
              "missing, accepted are two corners [[x0, y0], [x1, y1]]");
    return;
  }
  if (!open_list(faults, *area)) return;
  if (area->node->items.size() != 2) {
    add_fault(faults, area->place, area->path,
              fmt::format("a list of {} stands here, accepted are two corners "
                          "[[x0, y0], [x1, y1]]",
                          area->node->items.size()));
    return;
  }
  // read_numbers looks for keys: each corner stands in a map of its own.
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string key = std::to_string(i);
    Node holder;
    holder.kind = NodeKind::map;
    holder.keys.push_back({key, false, area->place});
    holder.items.push_back(area->node->items[i]);
    if (!read_numbers(faults, {&holder, area->place, area->path}, key, kPosition,
                      place.area_m[i])) {
      return;
    }
  }
  const auto& [from, to] = place.area_m;
  if (from[0] <= to[0] && from[1] <= to[1]) return;
  add_fault(faults, area->place, area->path,
            "the second corner is not to the east and north of the first, accepted is "
            "[[x0, y0], [x1, y1]] with x0 <= x1 and y0 <= y1");
}

const std::string* text_of(const Value& map, std::string_view key) {
  if (map.node->kind != NodeKind::map) return nullptr;
  const Node* node = find(*map.node, key);
  return node != nullptr && node->kind == NodeKind::scalar ? &node->text : nullptr;
}

}  // namespace

void parse_place(Faults& faults, const Value& map, PlaceSpec& place) {
  if (!open_map(faults, map,
                {"on", "area_m", "clearance_m", "sink_m", "yaw", "align", "rotation_deg",
                 "quaternion_wxyz"})) {
    return;
  }
  read_text(faults, map, "on", place.on, Need::required);
  parse_area(faults, map, place);
  read_number(faults, map, "clearance_m", from_to(0, kMaxLengthM), place.clearance_m);
  read_number(faults, map, "sink_m", kPosition, place.sink_m);
  read_choice<bool>(faults, map, "yaw", {{"any", true}, {"fixed", false}}, place.any_yaw);
  read_choice<bool>(faults, map, "align", {{"up", false}, {"surface", true}}, place.along_surface);
  PoseSpec pose;
  parse_pose(faults, map, pose);
  place.rotation = pose.rotation;
}

void check_places(Faults& faults, const Value& objects) {
  std::unordered_set<std::string_view> before;
  std::vector<std::string_view> all;
  for (std::size_t i = 0; i < objects.node->items.size(); ++i) {
    if (const std::string* name = text_of(item(objects, i), "name")) all.push_back(*name);
  }
  for (std::size_t i = 0; i < objects.node->items.size(); ++i) {
    const Value object = item(objects, i);
    const std::string* name = text_of(object, "name");
    const auto place = object.node->kind == NodeKind::map ? child(object, "place") : std::nullopt;
    const std::string* on = place ? text_of(*place, "on") : nullptr;
    if (on != nullptr && !before.contains(*on)) {
      const Value value = *child(*place, "on");
      if (!needs_words(faults, value.place, value.path)) continue;
      const bool later = std::find(all.begin(), all.end(), *on) != all.end();
      add_fault(faults, value.place, value.path,
                fmt::format("{} {}{}, accepted is the name of an object that stands before this "
                            "one in the list",
                            later ? "the object" : "no object", shown(*on),
                            later ? " does not stand before this one" : hint(*on, all)));
    }
    if (name != nullptr) before.insert(*name);
  }
}

}  // namespace ensonify
