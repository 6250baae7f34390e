// The keys of random places, and the objects that these refer to.
#include <algorithm>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include <fmt/format.h>

#include "scenario/sections.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

// Reads two corners, of which the second must not be below the first on any axis. Returns whether
// they were read.
template <std::size_t N>
bool corner_fields(Fields& f, const KeyText& text, std::array<std::array<double, N>, 2>& corner,
                   const ListWords& words, const Rule& rule) {
  std::size_t corners = 2;
  if (!f.begin(text, ListBranch{corners, words}, rule)) return false;
  const bool has_first = f.numbers("0", corner[0], kPosition);
  const bool has_second = f.numbers("1", corner[1], kPosition);
  f.end();
  return has_first && has_second;
}

template <std::size_t N>
bool is_in_order(const std::array<std::array<double, N>, 2>& corner) {
  for (std::size_t i = 0; i < N; ++i) {
    if (!(corner[0][i] <= corner[1][i])) return false;
  }
  return true;
}

void area_field(Fields& f, PlaceSpec& place, const Rule& rule) {
  const bool is_read =
      corner_fields(f,
                    {"area_m", "Area",
                     "[[x0, y0], [x1, y1]] in the world: the rectangle in which the center of the "
                     "object is placed"},
                    place.area_m, {"", "two corners [[x0, y0], [x1, y1]]", 2, 2}, rule);
  if (!is_read || is_in_order(place.area_m)) return;
  f.fault("area_m",
          "the second corner is not northeast of the first; expected [[x0, y0], [x1, y1]] with x0 "
          "<= x1 and y0 <= y1");
}

void volume_field(Fields& f, PlaceSpec& place) {
  auto corner = place.volume_m.value_or(std::array<std::array<double, 3>, 2>{});
  const bool is_read = corner_fields(
      f,
      {"volume_m", "Volume",
       "[[x0, y0, z0], [x1, y1, z1]] in the world: the box of water in which the center of the "
       "object is placed, in place of on and area_m; left out: the object stands on something"},
      corner, {"", "two corners [[x0, y0, z0], [x1, y1, z1]]", 2, 2},
      written_if(place.volume_m.has_value(), {.has_default = false}));
  if (!is_read) return;
  place.volume_m = corner;
  if (is_in_order(corner)) return;
  f.fault("volume_m",
          "the second corner is not northeast of the first and above it; expected [[x0, y0, z0], "
          "[x1, y1, z1]] with x0 <= x1, y0 <= y1 and z0 <= z1");
}

const std::string* text_of(const Value& map, std::string_view key) {
  if (map.node->kind != NodeKind::map) return nullptr;
  const Node* node = find(*map.node, key);
  return node != nullptr && node->kind == NodeKind::scalar ? &node->text : nullptr;
}

}  // namespace

const char* name_of(PlaceAlignment alignment) {
  if (alignment == PlaceAlignment::rest) return "rest";
  return alignment == PlaceAlignment::up ? "up" : "surface";
}

const char* name_of(PlaceFailure failure) {
  switch (failure) {
    case PlaceFailure::redraw:
      return "redraw";
    case PlaceFailure::skip_object:
      return "skip_object";
    case PlaceFailure::skip_sequence:
      return "skip_sequence";
    case PlaceFailure::error:
      return "error";
  }
  return "";
}

static void fields(Fields& f, ScourSpec& scour) {
  f.number({"depth_m", "Depth", "Greatest depth of the pit around the object"}, scour.depth_m,
           from_to(0, 1e3), kRequired);
  f.number({"width_m", "Width", "Width of the pit, from the outline of the object outward"},
           scour.width_m, kLength, kRequired);
  f.number({"mound_m", "Height of the mound",
            "Greatest height of the mound beyond the pit, whose width follows from the volume of "
            "the pit; left out: half of depth_m"},
           scour.mound_m, above_up_to(0, 1e3));
  f.number({"direction_deg", "Direction of the flow",
            "Direction toward which the water flows, from x toward y: the pit is deepest upstream "
            "and the mound highest downstream; left out: both are the same all around"},
           scour.direction_deg, from_to(-360, 360));
}

void fields(Fields& f, PlaceSpec& place) {
  const bool floats = f.writing() ? place.volume_m.has_value() : f.peek("volume_m") != nullptr;
  const auto on_ground = [&](Rule rule = {}) {
    return useless_if(floats, "with volume_m, where the object does not stand on anything", rule);
  };
  f.text({"on", "On", "Name of an earlier object in the list, on which this one stands"}, place.on,
         on_ground(kRequired));
  area_field(f, place, on_ground(kRequired));
  volume_field(f, place);
  f.number({"height_m", "Height",
            "Height of the object in the water above the place where it would stand"},
           place.height_m, from_to(0, kMaxLengthM), on_ground(written_if(place.height_m != 0)));
  f.number({"clearance_m", "Clearance",
            "Smallest distance between the outlines of placed objects, seen from above"},
           place.clearance_m, from_to(0, kMaxLengthM));
  f.boolean(
      {"touching", "Touching",
       "The object is moved toward the nearest one on the same ground until their outlines touch"},
      place.touching, on_ground());
  f.boolean({"heap", "Heap",
             "The object may also lie on other objects placed on the same ground: it rests on "
             "whatever is highest under it"},
            place.heap, on_ground(written_if(place.heap)));
  f.number({"sink_m", "Burial depth", "How far the object is lowered into the ground"},
           place.sink_m, kPosition, on_ground());
  f.number({"buried_fraction", "Buried fraction",
            "Share of its height by which the object is lowered, in addition to sink_m"},
           place.buried_fraction, from_to(0, 1), on_ground());
  f.choice<bool>({"yaw", "Yaw",
                  "any: the object is turned about the vertical by a random angle; fixed: it is "
                  "not turned"},
                 place.any_yaw, {{"any", true}, {"fixed", false}});
  f.choice<PlaceAlignment>(
      {"align", "Alignment",
       "up: the z axis of the object is vertical; surface: it is normal to the ground under the "
       "object; rest: the object lies on a random face of its convex hull on which it is stable"},
      place.align, words_to(PlaceAlignment::rest), on_ground());
  rotation_fields(f, place.rotation,
                  "[roll, pitch, yaw] of the object before it is turned and aligned");
  f.choice<PlaceFailure>(
      {"on_failure", "Where there is no room",
       "What happens if no free place is found: redraw: everything that is sampled for the "
       "sequence is sampled again; skip_object: the sequence has no such object; skip_sequence: "
       "the data set has no such sequence; error: the run ends"},
      place.on_failure, words_to(PlaceFailure::error));
  f.map({"scour", "Scour",
         "A pit around the object and a mound of the same volume; on terrain only; left out: none"},
        place.scour, on_ground());
  if (place.heap && place.touching) {
    f.fault("touching", "has no effect with heap; expected only one of them");
  }
}

namespace {

// The objects of the list by name, and the parents that they name.
struct Families {
  std::unordered_map<std::string_view, std::size_t> index;
  std::vector<std::string_view> names;       // of each object
  std::vector<std::optional<Value>> parent;  // of each object, if it is a text
};

Families families_of(const Value& objects) {
  Families families;
  for (std::size_t i = 0; i < objects.node->items.size(); ++i) {
    const Value object = item(objects, i);
    const std::string* name = text_of(object, "name");
    if (name != nullptr) families.index.emplace(*name, i);
    families.names.push_back(name != nullptr ? std::string_view(*name) : "");
    const auto pose = object.node->kind == NodeKind::map ? child(object, "pose") : std::nullopt;
    const bool has_parent = pose && text_of(*pose, "parent") != nullptr;
    families.parent.push_back(has_parent ? child(*pose, "parent") : std::nullopt);
  }
  return families;
}

// The object without a parent at the end of a chain of parents; empty if the chain is broken or a
// cycle.
std::optional<std::size_t> root_of(const Families& families, std::size_t object) {
  for (std::size_t steps = 0; steps <= families.parent.size(); ++steps) {
    if (!families.parent[object]) return object;
    const auto next = families.index.find(families.parent[object]->node->text);
    if (next == families.index.end()) return std::nullopt;
    object = next->second;
  }
  return std::nullopt;
}

// The names of a cycle of parents, for the first of its objects in the list; otherwise empty.
std::string cycle_at(const Families& families, std::size_t first) {
  std::string names;
  std::size_t object = first;
  for (std::size_t steps = 0; steps <= families.parent.size(); ++steps) {
    if (!families.parent[object]) return "";
    const std::string& parent = families.parent[object]->node->text;
    const auto next = families.index.find(parent);
    if (next == families.index.end() || next->second < first) return "";
    names += (names.empty() ? "" : ", ") + parent;
    object = next->second;
    if (object == first) return names;
  }
  return "";
}

}  // namespace

void check_parents(Faults& faults, const Value& root) {
  const auto objects = child(root, "objects");
  if (!objects || objects->node->kind != NodeKind::list) return;
  const Families families = families_of(*objects);
  for (std::size_t i = 0; i < families.parent.size(); ++i) {
    if (!families.parent[i]) continue;
    const Value& parent = *families.parent[i];
    if (!families.index.contains(parent.node->text)) {
      if (!needs_words(faults, parent.place, parent.path)) continue;
      add_fault(faults, parent.place, parent.path,
                fmt::format("no object {}{}; expected the name of an object",
                            shown(parent.node->text), hint(parent.node->text, families.names)));
    } else if (const std::string cycle = cycle_at(families, i); !cycle.empty()) {
      add_fault(faults, parent.place, parent.path,
                fmt::format("the parents {} form a cycle; expected a chain that ends at an object "
                            "without a parent",
                            one_line(cycle)));
    }
  }
}

static bool is_terrain(const Value& object) {
  const auto shape = object.node->kind == NodeKind::map ? child(object, "shape") : std::nullopt;
  return shape && shape->node->kind == NodeKind::map && child(*shape, "heightfield");
}

void check_places(Faults& faults, const Value& root) {
  const auto list = child(root, "objects");
  if (!list || list->node->kind != NodeKind::list) return;
  const Value& objects = *list;
  const Families families = families_of(objects);
  std::unordered_set<std::string_view> before;
  for (std::size_t i = 0; i < objects.node->items.size(); ++i) {
    const Value object = item(objects, i);
    const std::string* name = text_of(object, "name");
    const auto place = object.node->kind == NodeKind::map ? child(object, "place") : std::nullopt;
    const std::string* on = place ? text_of(*place, "on") : nullptr;
    if (on != nullptr && !before.contains(*on)) {
      const Value value = *child(*place, "on");
      if (!needs_words(faults, value.place, value.path)) continue;
      const bool later = families.index.contains(*on);
      add_fault(
          faults, value.place, value.path,
          fmt::format(
              "{} {}{}; expected the name of an object that comes before this one in the list",
              later ? "the object" : "no object", shown(*on),
              later ? " does not come before this one" : hint(*on, families.names)));
    }
    if (on != nullptr && before.contains(*on)) {
      const auto carrier = root_of(families, families.index.at(*on));
      if (carrier && *carrier >= i) {
        const Value value = *child(*place, "on");
        add_fault(faults, value.place, value.path,
                  fmt::format("the object {} moves with {}, which does not come before this one in "
                              "the list; expected an object whose parents all come before this one",
                              shown(*on), shown(families.names[*carrier])));
      }
    }
    const auto scour = place ? child(*place, "scour") : std::nullopt;
    if (scour && on != nullptr && before.contains(*on) &&
        !is_terrain(item(objects, families.index.at(*on)))) {
      add_fault(faults, scour->place, scour->path,
                fmt::format("{} has no heightfield; expected an object on terrain", shown(*on)));
    }
    if (name != nullptr) before.insert(*name);
  }
}

}  // namespace ensonify
