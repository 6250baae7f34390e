// The keys of objects and point targets: names, classes and poses.
#include <algorithm>
#include <cmath>
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

// Registers the names and classes of everything that has an instance id.
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
                  fmt::format("the name {} is already used by {}; expected a name that no other "
                              "object, point target or volume has",
                              shown(name->node->text), first->second));
      }
    }
    const auto class_name = child(entry, "class");
    const std::string_view name = class_name ? class_name->node->text : default_class;
    if (census.classes.insert(name).second && census.classes.size() == kMaxClasses + 1) {
      const Value& culprit = class_name ? *class_name : entry;
      add_fault(faults, culprit.place, culprit.path,
                fmt::format("there are more than {} different classes, the limit of a semantic "
                            "mask; expected fewer",
                            kMaxClasses));
    }
  }
}

}  // namespace

void rotation_fields(Fields& f, RotationSpec& rotation, std::string_view meaning) {
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
              "the quaternion has no length and thus no direction; expected w, x, y, z with a "
              "length above 1e-6, which the program normalizes");
      return;
    }
    rotation = Quat{q[0], q[1], q[2], q[3]};
  }
}

void fields(Fields& f, PoseSpec& pose) {
  f.numbers({"position_m", "Position", "[x, y, z]: x east, y north, z up"}, pose.position_m,
            kPosition);
  rotation_fields(f, pose.rotation,
                  "[roll, pitch, yaw], intrinsic z-y'-x''; positive pitch is nose down, positive "
                  "yaw is to port");
}

static void object_pose_fields(Fields& f, ObjectSpec& object, const Rule& rule) {
  if (!f.begin({"pose", "Pose", "Pose of an object at rest, or relative to its parent"}, rule))
    return;
  fields(f, object.pose);
  f.text({"parent", "Parent",
          "Name of the object in whose frame position_m and rotation are, and with which this one "
          "moves; left out: they are in the world"},
         object.parent, written_if(!object.parent.empty(), {.has_default = false}));
  f.end();
}

// A metal, or density and speeds.
static void elastic_material_fields(Fields& f, ElasticSpec& body) {
  constexpr std::string_view kKeys[] = {"material", "density_kg_m3"};
  const auto which = f.only_key(kKeys, body.metal ? 0 : 1,
                                "either material or density_kg_m3, speed_m_s and shear_speed_m_s");
  const Rule of_own =
      useless_if(which == 0u, "with material; expected only one of them",
                 {.need = Need::required, .unless = "material", .has_default = false});
  SphereMetal metal = body.metal.value_or(SphereMetal::tungsten_carbide);
  if (which == 0u) {
    const bool read = f.choice<SphereMetal>(
        {kKeys[0], "Material", "Tungsten carbide with 6 % cobalt, mild steel, aluminum or copper"},
        metal, words_to(SphereMetal::copper), {.has_default = false});
    if (read) body.metal = metal;
  }
  if (which == 1u) {
    f.number({kKeys[1], "Density", "Density of the material, in place of material", "kg/m³"},
             body.material.density_kg_m3, from_to(1, 1e5), of_own);
  }
  const bool speed = f.number({"speed_m_s", "Compressional speed", "Speed of compressional waves"},
                              body.material.speed_m_s, from_to(100, 2e4), of_own);
  const bool shear =
      f.number({"shear_speed_m_s", "Shear speed", "Speed of shear waves; 0: a fluid"},
               body.material.shear_speed_m_s, from_to(0, 2e4), of_own);
  if (speed && shear) {
    check_solid(f, body.material.speed_m_s, body.material.shear_speed_m_s);
  }
}

// `radius_m`: none if it is not known.
static void elastic_fields(Fields& f, ElasticSpec& body, std::optional<double> radius_m) {
  elastic_material_fields(f, body);
  const bool wall = f.number({"wall_m", "Wall", "Thickness of a shell; left out: a solid body"},
                             body.wall_m, above_up_to(0, 1));
  if (radius_m && wall && !(*body.wall_m < *radius_m)) {
    f.fault("wall_m", fmt::format("{} is not below the radius of {}; expected a thinner wall, or "
                                  "no wall_m for a solid body",
                                  *body.wall_m, *radius_m));
  }
  const bool solid = f.writing() ? !body.wall_m : f.peek("wall_m") == nullptr;
  f.choice<ShellFilling>({"filling", "Filling", "What the shell holds"}, body.filling,
                         {{"air", ShellFilling::air}, {"water", ShellFilling::water}},
                         useless_if(solid, "without wall_m"));
}

static void fields(Fields& f, RingingSphereSpec& sphere) {
  const bool radius = f.number({"radius_m", "Radius", "Radius of the sphere"}, sphere.radius_m,
                               above_up_to(0, 1), kRequired);
  elastic_fields(f, sphere, radius ? std::optional(sphere.radius_m) : std::nullopt);
}

// The radius of a shape that may be an elastic body; 0 if it could not be read.
static std::optional<double> elastic_radius_m(const ShapeSpec& shape) {
  if (const auto* cylinder = std::get_if<CylinderSpec>(&shape)) return cylinder->radius_m;
  const auto* sphere = std::get_if<SphereSpec>(&shape);
  return sphere != nullptr && !sphere->inside ? std::optional(sphere->radius_m) : std::nullopt;
}

static void object_elastic_fields(Fields& f, ObjectSpec& object) {
  const bool has_body = f.writing() ? object.elastic.has_value() : f.peek("elastic") != nullptr;
  if (!f.begin({"elastic", "Elastic body",
                "The sphere or cylinder echoes with its resonances, in addition to what its "
                "material scatters; left out: only the material echoes"},
               written_if(has_body, {.has_default = false}))) {
    return;
  }
  if (!object.elastic) object.elastic.emplace();
  const std::optional<double> radius_m = elastic_radius_m(object.shape);
  elastic_fields(f, *object.elastic, radius_m && *radius_m > 0 ? radius_m : std::nullopt);
  f.end();
  if ((radius_m && *radius_m <= 1) || (!f.writing() && f.peek("shape") == nullptr)) return;
  f.fault("elastic", radius_m
                         ? fmt::format("the radius of {} is too large; expected at most 1 m",
                                       *radius_m)
                         : "the shape has no resonances; expected a cylinder, or a sphere that "
                           "is not inward_facing");
}

void fields(Fields& f, ObjectSpec& object) {
  const bool writing = f.writing();
  const bool moves = writing ? object.trajectory.has_value() : f.peek("trajectory") != nullptr;
  const bool placed = writing ? object.place.has_value() : f.peek("place") != nullptr;
  constexpr std::string_view kBesidePlace = "with place; expected only one of them";
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
  object_elastic_fields(f, object);
  object_pose_fields(f, object,
                     useless_if(placed, kBesidePlace,
                                useless_if(moves, "with trajectory, whose poses replace it")));
  f.map({"place", "Place",
         "A random place on another object or in the water, in place of pose; left out: the object "
         "is where pose states"},
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
  constexpr std::string_view kStrengths[] = {"target_strength_db", "sphere"};
  const auto strength = f.only_key(kStrengths, target.sphere ? 1 : 0,
                                   "either target_strength_db or an elastic sphere");
  if (strength == 0u) {
    f.number(
        {kStrengths[0], "Target strength", "Target strength of the point target", "dB re 1 m²"},
        target.target_strength_db, from_to(-300, 300), {.has_default = false});
  }
  if (strength == 1u) {
    f.map({kStrengths[1], "Elastic sphere",
           "Sphere or shell with its resonances, in place of target_strength_db"},
          target.sphere);
  }
  f.numbers({"position_m", "Position", "[x, y, z] in the world"}, target.position_m, kPosition,
            kRequired);
}

// The material of that name, or what grows on it, if either has a specular echo or a wall.
static const MaterialSpec* coherent_material(const Scenario& scenario, const std::string& name) {
  const auto named = [&](const std::string& wanted) {
    return std::ranges::find(scenario.materials, wanted, &MaterialSpec::name);
  };
  const auto is_coherent = [](const MaterialSpec& material) {
    return material.wall || std::holds_alternative<KirchhoffSpec>(material.coherent);
  };
  const auto own = named(name);
  if (own == scenario.materials.end()) return nullptr;
  if (is_coherent(*own)) return &*own;
  if (!own->growth) return nullptr;
  const auto grown = named(own->growth->material);
  return grown != scenario.materials.end() && is_coherent(*grown) ? &*grown : nullptr;
}

void check_elastic(Faults& faults, const Value& root, const Scenario& scenario) {
  const auto list = child(root, "objects");
  if (!list || list->node->kind != NodeKind::list) return;
  const std::size_t count = std::min(scenario.objects.size(), list->node->items.size());
  for (std::size_t i = 0; i < count; ++i) {
    const ObjectSpec& object = scenario.objects[i];
    const auto value = child(item(*list, i), "elastic");
    if (!object.elastic || !value) continue;
    const MaterialSpec* material = coherent_material(scenario, object.material);
    if (material == nullptr) continue;
    const bool is_smooth = std::holds_alternative<KirchhoffSpec>(material->coherent);
    add_fault(faults, value->place, value->path,
              fmt::format("the material {} has {}, which would count the same echo twice; expected "
                          "a material that only scatters",
                          shown(material->name), is_smooth ? "a specular echo" : "a wall"));
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
                fmt::format("there are more than {} objects, point targets and volumes, the limit "
                            "of an instance mask; expected fewer",
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
