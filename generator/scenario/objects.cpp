// The keys of objects and point targets: names, classes, poses and places.
#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include <fmt/format.h>

#include "core/units.h"
#include "scenario/sections.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr std::size_t kMaxInstances = 65534;
constexpr std::size_t kMaxClasses = 255;

void area_fields(Fields& f, PlaceSpec& place) {
  std::size_t corners = 2;
  const ListWords words{"", "are two corners [[x0, y0], [x1, y1]]", 2, 2};
  if (!f.begin({"area_m", "Area",
                "[[x0, y0], [x1, y1]] in the world: the rectangle in which the center of the "
                "object is placed"},
               ListBranch{corners, words}, kRequired)) {
    return;
  }
  const bool has_first = f.numbers("0", place.area_m[0], kPosition);
  const bool has_second = f.numbers("1", place.area_m[1], kPosition);
  f.end();
  const auto& [from, to] = place.area_m;
  if (!has_first || !has_second || (from[0] <= to[0] && from[1] <= to[1])) return;
  f.fault("area_m",
          "the second corner is not to the east and north of the first, accepted is "
          "[[x0, y0], [x1, y1]] with x0 <= x1 and y0 <= y1");
}

const std::string* text_of(const Value& map, std::string_view key) {
  if (map.node->kind != NodeKind::map) return nullptr;
  const Node* node = find(*map.node, key);
  return node != nullptr && node->kind == NodeKind::scalar ? &node->text : nullptr;
}

// Holds the names and classes of everything that gets an id.
struct Census {
  std::unordered_map<std::string_view, std::string> name_paths;
  std::unordered_set<std::string_view> classes;
};

void count_list(Faults& faults, const Value& root, std::string_view key,
                std::string_view default_class, Census& census) {
  const auto list = child(root, key);
  if (!list || list->node->kind != NodeKind::list) return;
  for (std::size_t i = 0; i < list->node->items.size(); ++i) {
    const Value entry = item(*list, i);
    if (entry.node->kind != NodeKind::map) continue;
    if (const auto name = child(entry, "name"); name && name->node->kind == NodeKind::scalar) {
      const auto [first, fresh] = census.name_paths.emplace(name->node->text, name->path);
      if (!fresh) {
        add_fault(faults, name->place, name->path,
                  fmt::format("the name {} is taken by {}, names of objects, point targets "
                              "and volumes must differ",
                              shown(name->node->text), first->second));
      }
    }
    const auto class_name = child(entry, "class");
    const std::string_view name = class_name ? class_name->node->text : default_class;
    if (census.classes.insert(name).second && census.classes.size() == kMaxClasses + 1) {
      const Value& culprit = class_name ? *class_name : entry;
      add_fault(faults, culprit.place, culprit.path,
                fmt::format("more than {} different classes, which is what a semantic mask holds",
                            kMaxClasses));
    }
  }
}

}  // namespace

static void rotation_fields(Fields& f, RotationSpec& rotation, std::string_view meaning) {
  constexpr std::string_view kKeys[] = {"rotation_deg", "quaternion_wxyz"};
  const auto which =
      f.only_key(kKeys, rotation.index(), "rotation_deg (roll, pitch, yaw) or quaternion_wxyz",
                 Need::optional);
  if (which == 0u) {
    const auto* given = std::get_if<std::array<double, 3>>(&rotation);
    std::array<double, 3> angles = given != nullptr ? *given : std::array<double, 3>{};
    const KeyText text = {kKeys[0], "Rotation", meaning};
    if (f.numbers(text, angles, from_to(-36000, 36000))) rotation = angles;
  } else if (which == 1u) {
    const auto* given = std::get_if<Quat>(&rotation);
    std::array<double, 4> q{};
    if (given != nullptr) q = {given->w, given->x, given->y, given->z};
    const KeyText text = {kKeys[1], "Rotation as a quaternion",
                          "[w, x, y, z] of any length, normalized by the program; in place of "
                          "rotation_deg; left out: as rotation_deg states"};
    if (!f.numbers(text, q, from_to(-1e6, 1e6), {.has_default = false})) return;
    if (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] < 1e-12) {
      f.fault(kKeys[1],
              "has no length and so no direction, accepted is any quaternion w, x, y, z longer "
              "than 1e-6; it is normalised");
      return;
    }
    rotation = Quat{q[0], q[1], q[2], q[3]};
  }
}

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

void fields(Fields& f, PoseSpec& pose) {
  f.numbers({"position_m", "Position", "[x, y, z]: x east, y north, z up"}, pose.position_m,
            kPosition);
  rotation_fields(f, pose.rotation,
                  "[roll, pitch, yaw], intrinsic z-y'-x''; positive pitch is nose down, positive "
                  "yaw is to port");
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
  f.text({"on", "On", "Name of the object to stand on, which comes earlier in the list"}, place.on,
         kRequired);
  area_fields(f, place);
  f.number({"clearance_m", "Clearance",
            "Smallest distance between the outlines of placed objects, seen from above"},
           place.clearance_m, from_to(0, kMaxLengthM));
  f.boolean({"touching", "Touching",
             "The object is moved towards the nearest one on the same ground until their outlines "
             "touch"},
            place.touching);
  f.number({"sink_m", "Burial depth", "How far the object is lowered into the ground"},
           place.sink_m, kPosition);
  f.number({"buried_fraction", "Buried fraction",
            "Share of its height by which the object is lowered, in addition to sink_m"},
           place.buried_fraction, from_to(0, 1));
  f.choice<bool>({"yaw", "Yaw",
                  "any: the object is turned about the vertical by a random angle; fixed: it is "
                  "not turned"},
                 place.any_yaw, {{"any", true}, {"fixed", false}});
  f.choice<PlaceAlignment>(
      {"align", "Alignment",
       "up: the z axis of the object is vertical; surface: it is normal to the ground under the "
       "object; rest: the object lies on a random face of its convex hull on which it is stable"},
      place.align, words_to(PlaceAlignment::rest));
  rotation_fields(f, place.rotation,
                  "[roll, pitch, yaw] of the object before it is turned and aligned");
  f.choice<PlaceFailure>(
      {"on_failure", "Where there is no room",
       "What happens where no free place is found: redraw: everything that is sampled for the "
       "sequence is sampled again; skip_object: the sequence has no such object; skip_sequence: the "
       "data set has no such sequence; error: the run ends"},
      place.on_failure, words_to(PlaceFailure::error));
  f.map({"scour", "Scour",
         "A pit around the object and a mound of the same volume; on terrain only; left out: none"},
        place.scour);
}

void fields(Fields& f, ObjectSpec& object) {
  const bool writing = f.writing();
  const bool moves = writing ? object.trajectory.has_value() : f.peek("trajectory") != nullptr;
  const bool placed = writing ? object.place.has_value() : f.peek("place") != nullptr;
  constexpr std::string_view kBesidePlace = "beside a place, accepted is either alone";
  f.text({"name", "Name", "Name that no other object, point target or volume has"}, object.name,
         kRequired);
  f.text(
      {"class", "Class", "Class of the instance; class ids follow the order of first appearance"},
      object.class_name);
  f.describe_count({"count", "Copies",
                    "Number of objects that the entry stands for, called name_0, name_1, ...; each "
                    "is sampled separately; left out: one object, called name"},
                   0, kMaxCount);
  f.material({"material", "Material", "A key of materials"}, object.material);
  f.map({"shape", "Shape", "Exactly one shape"}, object.shape, kRequired);
  f.map({"pose", "Pose", "Pose of an object at rest"}, object.pose,
        useless_if(placed, kBesidePlace,
                   useless_if(moves, "beside trajectory, whose poses take its place")));
  f.map({"place", "Place",
         "A random place on another object, in place of pose; left out: the object is where pose "
         "states"},
        object.place, written_if(!moves));
  f.map({"trajectory", "Trajectory of an object",
         "Exactly one path, and the wave motion, in place of pose; left out: at rest"},
        object.trajectory, useless_if(placed && !writing, kBesidePlace));
}

void fields(Fields& f, PointTargetSpec& target) {
  f.text({"name", "Name", "Name that no other object, point target or volume has"}, target.name,
         kRequired);
  f.text({"class", "Class", "Class of the instance"}, target.class_name);
  f.describe_count({"count", "Copies",
                    "Number of point targets that the entry stands for, called name_0, name_1, "
                    "...; each is sampled separately; left out: one point target, called name"},
                   0, kMaxCount);
  f.number({"target_strength_db", "Target strength", "Target strength of the point target",
            "dB re 1 m²"},
           target.target_strength_db, from_to(-300, 300), kRequired);
  f.numbers({"position_m", "Position", "[x, y, z] in the world"}, target.position_m, kPosition,
            kRequired);
}

static bool is_terrain(const Value& object) {
  const auto shape = object.node->kind == NodeKind::map ? child(object, "shape") : std::nullopt;
  return shape && shape->node->kind == NodeKind::map && child(*shape, "heightfield");
}

void check_places(Faults& faults, const Value& root) {
  const auto list = child(root, "objects");
  if (!list || list->node->kind != NodeKind::list) return;
  const Value& objects = *list;
  std::unordered_map<std::string_view, bool> before;  // whether it is terrain
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
    const auto scour = place ? child(*place, "scour") : std::nullopt;
    if (scour && on != nullptr && before.contains(*on) && !before.at(*on)) {
      add_fault(faults, scour->place, scour->path,
                fmt::format("{} has no heightfield; expected an object on terrain", shown(*on)));
    }
    if (name != nullptr) before.emplace(*name, is_terrain(object));
  }
}

void check_instances(Faults& faults, const Value& root) {
  const ObjectSpec object;
  const PointTargetSpec target;
  const VolumeSpec volume;
  Census census;
  count_list(faults, root, "objects", object.class_name, census);
  count_list(faults, root, "point_targets", target.class_name, census);
  count_list(faults, root, "volumes", volume.class_name, census);
  std::size_t count = 0;
  for (const char* key : {"objects", "point_targets", "volumes"}) {
    const auto list = child(root, key);
    if (!list || list->node->kind != NodeKind::list) continue;
    const std::size_t before = count;
    count += list->node->items.size();
    if (before <= kMaxInstances && count > kMaxInstances) {
      add_fault(faults, list->place, list->path,
                fmt::format("more than {} objects, point targets and volumes, which is what an "
                            "instance mask holds",
                            kMaxInstances));
    }
  }
}

Pose pose_of(const PoseSpec& spec) {
  Pose pose;
  pose.position_m = {spec.position_m[0], spec.position_m[1], spec.position_m[2]};
  if (const auto* angles = std::get_if<std::array<double, 3>>(&spec.rotation)) {
    pose.rotation =
        from_roll_pitch_yaw(radians((*angles)[0]), radians((*angles)[1]), radians((*angles)[2]));
  } else {
    pose.rotation = normalized(std::get<Quat>(spec.rotation));
  }
  return pose;
}

}  // namespace ensonify
