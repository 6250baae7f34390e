#include <algorithm>
#include <fstream>
#include <system_error>
#include <unordered_map>
#include <unordered_set>

#include <fmt/format.h>

#include "scenario/parse.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr std::size_t kMaxInstances = 65534;
constexpr std::size_t kMaxClasses = 255;

void parse_object(const InputFolder& input, const Value& map, const MaterialNames& names,
                  ObjectSpec& object) {
  Faults& faults = input.faults;
  if (!open_map(faults, map, {"name", "class", "material", "shape", "pose", "place", "trajectory"}))
    return;
  read_text(faults, map, "name", object.name, Need::required);
  read_text(faults, map, "class", object.class_name);
  parse_material_name(faults, map, "material", names, object.material);
  if (const auto shape = child(map, "shape")) {
    parse_shape(input, *shape, names, object.shape);
  } else {
    add_fault(faults, map.place, path_of(map, "shape"),
              "missing, accepted is one of box, sphere, cylinder, plane, mesh, heightfield, model, "
              "level_set");
  }
  if (const auto pose = child(map, "pose"); pose && open_map(faults, *pose, kPoseKeys)) {
    parse_pose(faults, *pose, object.pose);
  }
  if (const auto place = child(map, "place")) {
    parse_place(faults, *place, object.place.emplace());
    refuse_useless(faults, map, {"pose", "trajectory"}, "beside a place, accepted is either alone");
  }
  if (const auto trajectory = child(map, "trajectory")) {
    parse_object_trajectory(input, *trajectory, object.trajectory.emplace());
    refuse_useless(faults, map, {"pose"}, "beside trajectory, whose poses take its place");
  }
}

// Names and classes of everything that gets an id.
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

void add_class(const std::string& name, std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

// All scalars below: the value of `class`, or what it is drawn from.
void add_scalars(const Node& node, std::vector<std::string>& names) {
  if (node.kind == NodeKind::scalar) add_class(node.text, names);
  for (const Node& item : node.items) add_scalars(item, names);
}

// Of an entry, or of all that it, or the list, is drawn from.
void add_classes(const Node& node, const std::string& default_class,
                 std::vector<std::string>& names) {
  const Node* alternatives = node.kind == NodeKind::map ? find(node, "choice") : nullptr;
  if (alternatives != nullptr || node.kind == NodeKind::list) {
    for (const Node& item : (alternatives != nullptr ? *alternatives : node).items) {
      add_classes(item, default_class, names);
    }
  } else if (const Node* given = find(node, "class")) {
    add_scalars(*given, names);
  } else {
    add_class(default_class, names);
  }
}

}  // namespace

std::vector<std::string> class_names(const Value& root) {
  std::vector<std::string> names;
  const auto add_list = [&](std::string_view key, const std::string& default_class) {
    const auto list = child(root, key);
    if (list && !list->node->items.empty()) add_classes(*list->node, default_class, names);
  };
  add_list("objects", ObjectSpec{}.class_name);
  add_list("point_targets", PointTargetSpec{}.class_name);
  add_list("volumes", VolumeSpec{}.class_name);
  return names;
}

void parse_material_name(Faults& faults, const Value& map, std::string_view key,
                         const MaterialNames& names, std::string& material) {
  if (!read_text(faults, map, key, material, Need::required)) return;
  if (names.set.contains(material)) return;
  const Value value = *child(map, key);
  if (!needs_words(faults, value.place, value.path)) return;
  std::string accepted = "none is defined under materials";
  if (!names.list.empty()) accepted = "accepted are the keys of materials: " + joined(names.list);
  add_fault(
      faults, value.place, value.path,
      fmt::format("no material {}{}, {}", shown(material), hint(material, names.list), accepted));
}

void parse_pose(Faults& faults, const Value& map, PoseSpec& pose) {
  const NumberRange position = from_to(-kMaxLengthM, kMaxLengthM);
  read_numbers(faults, map, "position_m", position, pose.position_m);
  if (!child(map, "rotation_deg") && !child(map, "quaternion_wxyz")) return;
  const auto key = only_key_of(faults, map, {"rotation_deg", "quaternion_wxyz"},
                               "rotation_deg (roll, pitch, yaw) or quaternion_wxyz");
  if (!key) return;
  if (*key == "rotation_deg") {
    std::array<double, 3> angles{};
    if (read_numbers(faults, map, *key, from_to(-36000, 36000), angles)) pose.rotation = angles;
    return;
  }
  std::array<double, 4> q{};
  if (!read_numbers(faults, map, *key, from_to(-1e6, 1e6), q)) return;
  const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (square < 1e-12) {
    const Value value = *child(map, *key);
    add_fault(faults, value.place, value.path,
              "has no length and so no direction, accepted is any quaternion w, x, y, z longer "
              "than 1e-6; it is normalised");
    return;
  }
  pose.rotation = Quat{q[0], q[1], q[2], q[3]};
}

bool parse_input_file(const InputFolder& input, const Value& map, std::string_view key,
                      const std::vector<std::string_view>& extensions,
                      std::filesystem::path& file) {
  std::string name;
  if (!read_text(input.faults, map, key, name, Need::required, kMaxFileNameBytes)) return false;
  const Value value = *child(map, key);
  const auto refuse = [&](std::string_view trouble) {
    add_fault(input.faults, value.place, value.path,
              fmt::format("{} {}, accepted is a readable file ending in {}", shown(name), trouble,
                          joined(extensions)));
    return false;
  };
  const std::filesystem::path found = (input.folder / name).lexically_normal();
  const std::string extension = found.extension().string();
  if (std::none_of(extensions.begin(), extensions.end(), [&](std::string_view accepted) {
        return equals_ignoring_case(extension, accepted);
      })) {
    return refuse("has another ending");
  }
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(found, error);
  if (!std::filesystem::exists(status)) return refuse("is not there");
  if (std::filesystem::is_directory(status)) return refuse("is a folder");
  if (!std::filesystem::is_regular_file(status)) return refuse("is no regular file");
  if (!std::ifstream(found).good()) return refuse("cannot be read");
  file = found;
  return true;
}

void parse_objects(const InputFolder& input, const Value& value,
                   const std::vector<MaterialSpec>& materials, std::vector<ObjectSpec>& objects) {
  if (!open_list(input.faults, value)) return;
  MaterialNames names;
  for (const MaterialSpec& material : materials) {
    names.set.insert(material.name);
    names.list.push_back(material.name);
  }
  objects.resize(value.node->items.size());
  for (std::size_t i = 0; i < objects.size(); ++i) {
    parse_object(input, item(value, i), names, objects[i]);
  }
  check_places(input.faults, value);
}

void parse_point_targets(Faults& faults, const Value& value,
                         std::vector<PointTargetSpec>& targets) {
  if (!open_list(faults, value)) return;
  targets.resize(value.node->items.size());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Value map = item(value, i);
    PointTargetSpec& target = targets[i];
    if (!open_map(faults, map, {"name", "class", "target_strength_db", "position_m"})) continue;
    read_text(faults, map, "name", target.name, Need::required);
    read_text(faults, map, "class", target.class_name);
    read_number(faults, map, "target_strength_db", from_to(-300, 300), target.target_strength_db,
                Need::required);
    read_numbers(faults, map, "position_m", from_to(-kMaxLengthM, kMaxLengthM), target.position_m,
                 Need::required);
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

}  // namespace ensonify
