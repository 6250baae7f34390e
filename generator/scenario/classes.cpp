// The classes of objects, point targets and volumes, and the kind (thing or stuff) of each.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "scenario/distribution.h"
#include "scenario/sections.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

// Whether `holds` is true of a node, or of every alternative that the node can be sampled as.
template <class Holds>
bool always(const Node* node, const Holds& holds) {
  if (node == nullptr) return false;
  const Node* alternatives = node->kind == NodeKind::map ? find(*node, "choice") : nullptr;
  if (alternatives == nullptr || alternatives->kind != NodeKind::list) return holds(*node);
  return std::all_of(alternatives->items.begin(), alternatives->items.end(),
                     [&](const Node& item) { return always(&item, holds); });
}

bool is_room(const Node& shape) {
  return always(&shape, [](const Node& options) {
    const Node* inward = options.kind == NodeKind::map ? find(options, "inward_facing") : nullptr;
    return always(inward, [](const Node& word) { return word.text == "true"; });
  });
}

// Terrain, planes and rooms surround other objects; a box around one would cover the whole image.
bool is_stuff(const Node& shape) {
  if (shape.kind != NodeKind::map || shape.keys.size() != 1) return false;
  const std::string& kind = shape.keys[0].text;
  return kind == "heightfield" || kind == "plane" || is_room(shape.items[0]);
}

void add_class(const std::string& name, ClassKind kind, ClassList& list) {
  const auto found = std::find(list.names.begin(), list.names.end(), name);
  if (found == list.names.end()) {
    list.names.push_back(name);
    list.kinds.push_back(kind);
  } else if (kind == ClassKind::thing) {
    list.kinds[static_cast<std::size_t>(found - list.names.begin())] = kind;
  }
}

// Adds every scalar below the node: the value of `class`, or its alternatives.
void add_scalars(const Node& node, ClassKind kind, ClassList& list) {
  if (node.kind == NodeKind::scalar) add_class(node.text, kind, list);
  for (const Node& item : node.items) add_scalars(item, kind, list);
}

// The class of a list entry that names none, and whether its shape determines its kind.
struct EntryDefaults {
  std::string class_name;
  bool is_stuff = false;
};

// Adds the classes of an entry, or of every alternative that the entry or the list has.
void add_classes(const Node& node, const EntryDefaults& defaults, ClassList& list) {
  const Node* alternatives = node.kind == NodeKind::map ? find(node, "choice") : nullptr;
  if (alternatives != nullptr || node.kind == NodeKind::list) {
    for (const Node& item : (alternatives != nullptr ? *alternatives : node).items) {
      add_classes(item, defaults, list);
    }
    return;
  }
  const bool stuff = defaults.is_stuff || always(find(node, "shape"), is_stuff);
  const ClassKind kind = stuff ? ClassKind::stuff : ClassKind::thing;
  if (const Node* given = find(node, "class")) {
    add_scalars(*given, kind, list);
  } else {
    add_class(defaults.class_name, kind, list);
  }
}

// Leaves an invalid kind to the reader of the fields, which reports it.
void take_kinds(Faults& faults, const Value& classes, ClassList& list) {
  const std::vector<std::string_view> known(list.names.begin(), list.names.end());
  for (std::size_t i = 0; i < classes.node->keys.size(); ++i) {
    const std::string& name = classes.node->keys[i].text;
    const Value entry = *child(classes, name);
    const auto found = std::find(list.names.begin(), list.names.end(), name);
    if (found == list.names.end()) {
      add_fault(
          faults, entry.place, entry.path,
          fmt::format("no object, point target or volume has the class {}{}; expected a class "
                      "of this scenario{}{}",
                      shown(name), hint(name, known), known.empty() ? "" : ": ", joined(known)));
      continue;
    }
    const Node* kind = entry.node->kind == NodeKind::map ? find(*entry.node, "kind") : nullptr;
    if (kind == nullptr) continue;
    for (const ClassKind word : {ClassKind::thing, ClassKind::stuff}) {
      if (kind->text != name_of(word)) continue;
      list.kinds[static_cast<std::size_t>(found - list.names.begin())] = word;
    }
  }
}

}  // namespace

ClassList class_list(Faults& faults, const Value& root) {
  ClassList list;
  const auto add_list = [&](std::string_view key, const EntryDefaults& defaults) {
    const auto entries = child(root, key);
    if (entries && !entries->node->items.empty()) add_classes(*entries->node, defaults, list);
  };
  add_list("objects", {ObjectSpec{}.class_name});
  add_list("point_targets", {PointTargetSpec{}.class_name});
  add_list("volumes", {VolumeSpec{}.class_name, true});
  const auto classes = child(root, "classes");
  if (!classes || classes->node->kind != NodeKind::map) return list;
  if (holds_distribution(*classes->node)) {
    add_fault(faults, classes->place, classes->path,
              "cannot be sampled, because a class has the same kind in all sequences; expected "
              "thing or stuff");
    return list;
  }
  take_kinds(faults, *classes, list);
  return list;
}

void class_fields(Fields& f, std::vector<ClassSpec>& classes) {
  std::vector<std::string> names;
  for (const ClassSpec& of : classes) names.push_back(of.name);
  if (!f.begin({"classes", "Classes",
                "Kinds of classes, by the names that objects, point targets and volumes give; the "
                "kind of other classes follows from their shapes; left out: all follow from "
                "shapes"},
               NamesBranch{names,
                           "not a map; expected a map of classes, such as {seabed: {kind: stuff}}"},
               written_if(!classes.empty(), {.in_lines = true}))) {
    return;
  }
  classes.resize(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (f.begin(names[i])) {
      f.choice<ClassKind>({"kind", "Kind",
                           "thing: a countable object, which has a box in exports; stuff: its "
                           "surroundings, such as a seabed or a tank, which have none"},
                          classes[i].kind, words_to(ClassKind::stuff), kRequired);
      f.end();
    }
    classes[i].name = std::move(names[i]);
  }
  f.end();
}

}  // namespace ensonify
