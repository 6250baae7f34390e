#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "core/random.h"
#include "scenario/rig.h"
#include "scenario/scenario.h"
#include "scenario/tables.h"
#include "scenario/text.h"
#include "world/mesh.h"
#include "world/object_shapes.h"
#include "world/outline.h"
#include "world/place.h"
#include "world/scour.h"
#include "world/smooth_body.h"
#include "world/terrain.h"
#include "world/world.h"

namespace ensonify {
namespace {

// All errors of the input files, one line each, with its key.
struct WorldFaults {
  std::string lines;
  bool usage = false;  // at least one of them is not a reading error

  void add(const std::string& key, const Error& error) {
    std::istringstream message(error.message);
    for (std::string line; std::getline(message, line);) {
      lines += fmt::format("{}{}: {}", lines.empty() ? "" : "\n", key, line);
    }
    usage |= error.kind != ErrorKind::io;
  }
};

// Terrain from equal files is equal; synthetic terrain differs between objects.
using TerrainCache = std::vector<std::pair<HeightfieldSpec, std::shared_ptr<const Mesh>>>;

// Stores the terrain in `kept` unless it is null. Returns nothing on error.
std::shared_ptr<const Mesh> terrain_mesh(const HeightfieldSpec& spec, std::uint64_t terrain_key,
                                         const std::string& key, TerrainCache& cache, Terrain* kept,
                                         WorldFaults& faults) {
  for (const auto& [earlier, mesh] : cache) {
    if (kept == nullptr && !is_random(spec) && earlier == spec) return mesh;
  }
  std::string faulty_key;
  Result<Terrain> terrain = make_terrain(spec, terrain_key, faulty_key);
  if (!terrain) {
    faults.add(key + "." + faulty_key, terrain.error());
    return nullptr;
  }
  auto mesh = std::make_shared<const Mesh>(terrain_mesh(spec, *terrain));
  cache.emplace_back(spec, mesh);
  if (kept != nullptr) *kept = std::move(*terrain);
  return mesh;
}

std::uint8_t class_id(std::vector<std::string>& classes, const std::string& name) {
  const auto found = std::find(classes.begin(), classes.end(), name);
  if (found != classes.end()) return static_cast<std::uint8_t>(found - classes.begin() + 1);
  classes.push_back(name);
  return static_cast<std::uint8_t>(classes.size());
}

Instance& add_instance(World& world, const std::string& name, const std::string& class_name) {
  Instance instance;
  instance.id = static_cast<std::uint16_t>(world.instances.size() + 1);
  instance.name = name;
  instance.class_name = class_name;
  instance.class_id = class_id(world.classes, class_name);
  world.instances.push_back(instance);
  return world.instances.back();
}

std::map<std::string, Material> load_materials(const Scenario& scenario, WorldFaults& faults) {
  std::map<std::string, Material> materials;
  for (const MaterialSpec& spec : scenario.materials) {
    Material& material = materials[spec.name];
    material = material_of(spec, scenario.scattering);
    auto* measured = std::get_if<MeasuredStrength>(&material.law);
    if (measured == nullptr) continue;
    Result<BackscatterTable> loaded = load_backscatter_table(measured->file);
    if (loaded) {
      measured->table = std::move(*loaded);
    } else {
      faults.add(fmt::format("materials.{}.law.table.file", spec.name), loaded.error());
    }
  }
  return materials;
}

// The start of the sonar's path, if an object starts with it. An error of its file is reported with
// the sonar.
std::optional<double> first_ping_s(const Scenario& scenario) {
  const auto waits = [](const ObjectSpec& spec) {
    return spec.trajectory && spec.trajectory->from_first_ping;
  };
  if (std::none_of(scenario.objects.begin(), scenario.objects.end(), waits)) return std::nullopt;
  const Result<Path> path = load_path(scenario.trajectory, 0);
  return path ? std::optional(span_of(*path).start_s) : std::nullopt;
}

// Its wave motion is keyed by its name, so that adding other objects does not change it.
void set_path(const Scenario& scenario, const ObjectSpec& spec, SequenceDraw draw,
              std::optional<double> first_s, const std::string& key, WorldObject& object,
              std::vector<std::string>& warnings, WorldFaults& faults) {
  if (!spec.trajectory) return;
  const std::uint64_t stream = stream_key(scenario.seed, Stream::motion, draw);
  Result<Path> path = load_path(*spec.trajectory, mix64(stream ^ name_key(spec.name)),
                                spec.trajectory->from_first_ping ? first_s : std::nullopt);
  if (!path) {
    faults.add(key + ".trajectory.file", path.error());
    return;
  }
  if (std::string text = path_warning(*path); !text.empty()) {
    warnings.push_back(fmt::format("{}.trajectory.file: {}", key, text));
  }
  object.path = std::make_shared<const Path>(std::move(*path));
  object.pose = pose_at(*object.path, span_of(*object.path).start_s);
}

Error no_part(const MeshSpec& spec, const Mesh& mesh, const std::string& part) {
  const std::vector<std::string_view> names(mesh.part_names.begin(), mesh.part_names.end());
  const std::string file = spec.file.string();
  if (names.empty()) {
    return {ErrorKind::usage, file +
                                  ": has more than 256 names of materials or parts; `parts` needs "
                                  "256 or fewer"};
  }
  return {ErrorKind::usage, fmt::format("{}: has no part {}{}; expected one of {}", file,
                                        shown(part), hint(part, names), joined(names))};
}

// Parts with the same material share an index; parts with the object's own material need none.
void set_parts(const MeshSpec& spec, const Mesh& mesh,
               const std::map<std::string, Material>& materials, const std::string& key,
               WorldObject& object, Instance& instance, WorldFaults& faults) {
  PartMaterials& parts = object.parts;
  std::map<std::string, std::uint16_t> number = {{instance.material, 0}};
  for (const PartSpec& part : spec.parts) {
    const auto named = std::find(mesh.part_names.begin(), mesh.part_names.end(), part.part);
    if (named == mesh.part_names.end()) {
      faults.add(fmt::format("{}.{}", key, part.part), no_part(spec, mesh, part.part));
      continue;
    }
    const Material& material = materials.at(part.material);
    const auto [entry, fresh] = number.emplace(part.material, parts.materials.size() + 1);
    if (fresh) parts.materials.push_back(material);
    parts.of_part.resize(mesh.part_names.size(), 0);
    parts.of_part[named - mesh.part_names.begin()] = entry->second;
    instance.parts.push_back({part.part, part.material, material});
  }
  if (parts.materials.empty()) parts = {};
}

// Lays the image of a mesh on it.
void set_image(const MeshSpec& spec, const std::string& key, MeshLibrary& library, Shape& shape,
               Instance& instance, WorldFaults& faults) {
  instance.vertex_reflectivity = spec.vertex_reflectivity;
  if (spec.texture_file.empty()) return;
  instance.image_reflectivity = true;
  Result<std::shared_ptr<const ReflectivityImage>> image = library.image(spec.texture_file);
  if (image) {
    std::get<MeshShape>(shape).image = std::move(*image);
  } else {
    faults.add(key + ".texture_file", image.error());
  }
}

void make_smooth(const Scenario& scenario, std::size_t index, MeshLibrary& library, Shape& shape,
                 World& world, WorldFaults& faults) {
  const ObjectSpec& spec = scenario.objects[index];
  const auto* mesh = std::get_if<MeshSpec>(&spec.shape);
  const auto* solid = std::get_if<LevelSetSpec>(&spec.shape);
  if (mesh == nullptr && solid == nullptr) return;
  const std::string key =
      fmt::format("objects.{}.shape.{}.normals", index, solid != nullptr ? "level_set" : "mesh");
  std::vector<std::string> warnings;
  const Status made = smooth_body(scenario, spec, library_key(spec.shape, has_camera(scenario)),
                                  library, std::get<MeshShape>(shape), warnings);
  if (!made) faults.add(key, made.error());
  for (const std::string& warning : warnings) {
    world.warnings.push_back(fmt::format("{}: {}", key, warning));
  }
}

void add_objects(const Scenario& scenario, SequenceDraw draw,
                 const std::map<std::string, Material>& materials, MeshLibrary& library,
                 ScouredTerrain& scoured, World& world, WorldFaults& faults) {
  MeshCache meshes{&library, has_camera(scenario)};
  TerrainCache terrains;
  const std::optional<double> first_s = first_ping_s(scenario);
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const ObjectSpec& spec = scenario.objects[i];
    const auto* field = std::get_if<HeightfieldSpec>(&spec.shape);
    const auto kept = scoured.find(spec.name);
    std::vector<std::string> warnings;
    Result<Shape> shape =
        field == nullptr
            ? shape_of(spec.shape, meshes, warnings)
            : Shape(MeshShape{terrain_mesh(*field, terrain_key(scenario.seed, draw, spec.name),
                                           fmt::format("objects.{}.shape.heightfield", i), terrains,
                                           kept == scoured.end() ? nullptr : &kept->second, faults),
                              true});
    for (const std::string& warning : warnings) {
      world.warnings.push_back(fmt::format("objects.{}.shape.mesh.file: {}", i, warning));
    }
    if (!shape) {
      const bool solid = std::holds_alternative<LevelSetSpec>(spec.shape);
      faults.add(fmt::format("objects.{}.shape.{}.file", i, solid ? "level_set" : "mesh"),
                 shape.error());
      continue;
    }
    make_smooth(scenario, i, library, *shape, world, faults);
    Instance& instance = add_instance(world, spec.name, spec.class_name);
    instance.material = spec.material;
    instance.scattering = materials.at(spec.material);
    if (faults.lines.empty()) instance.box = box_of(*shape);  // an invalid file has no mesh
    const auto* mesh = std::get_if<MeshSpec>(&spec.shape);
    if (mesh != nullptr) {
      set_image(*mesh, fmt::format("objects.{}.shape.mesh", i), library, *shape, instance, faults);
    }
    if (field != nullptr && faults.lines.empty()) {
      instance.vertex_reflectivity = !std::get<MeshShape>(*shape).mesh->reflectivity.empty();
    }
    world.objects.push_back(
        {instance.id, std::move(*shape), pose_of(spec.pose), instance.scattering});
    WorldObject& object = world.objects.back();
    set_path(scenario, spec, draw, first_s, fmt::format("objects.{}", i), object, world.warnings,
             faults);
    if (mesh != nullptr) {
      set_parts(*mesh, *std::get<MeshShape>(object.shape).mesh, materials,
                fmt::format("objects.{}.shape.mesh.parts", i), object, instance, faults);
    }
    object.fields = make_fields(scenario, spec, draw, materials, object.parts, instance);
  }
}

std::vector<VolumeParts> load_volumes(const Scenario& scenario, SequenceDraw draw,
                                      WorldFaults& faults) {
  std::vector<VolumeParts> volumes;
  DensityCache cache;
  const std::uint64_t stream = stream_key(scenario.seed, Stream::bubbles, draw);
  for (std::size_t i = 0; i < scenario.volumes.size(); ++i) {
    const VolumeSpec& spec = scenario.volumes[i];
    Result<VolumeParts> parts = make_volume(spec, mix64(stream ^ name_key(spec.name)), cache);
    if (parts) {
      volumes.push_back(std::move(*parts));
    } else {
      faults.add(fmt::format("volumes.{}.{}", i, faulty_key(spec)), parts.error());
    }
  }
  return volumes;
}

void add_volume(const VolumeSpec& spec, VolumeParts parts, World& world) {
  Instance& instance = add_instance(world, spec.name, spec.class_name);
  instance.kind = InstanceKind::volume;
  instance.volume_strength_db = parts.strength_db;
  const auto* uniform = std::get_if<UniformVolumeSpec>(&spec.kind);
  if (uniform != nullptr && uniform->patches) instance.volume_patches = *uniform->patches;
  std::visit(
      [&](auto& part) {
        part.instance = instance.id;
        instance.box = box_of(part);
      },
      parts.part);
  if (auto* school = std::get_if<School>(&parts.part)) {
    world.schools.push_back(std::move(*school));
  } else {
    world.volumes.push_back(std::get<Volume>(std::move(parts.part)));
  }
}

}  // namespace

World empty_world(const Scenario& scenario) {
  World world;
  world.classes = scenario.class_names;
  for (const ObjectSpec& spec : scenario.objects) add_instance(world, spec.name, spec.class_name);
  for (const PointTargetSpec& spec : scenario.point_targets) {
    add_instance(world, spec.name, spec.class_name);
  }
  for (const VolumeSpec& spec : scenario.volumes) add_instance(world, spec.name, spec.class_name);
  return world;
}

Result<World> build_world(const Scenario& scenario, std::uint32_t sequence, MeshLibrary* library) {
  const SequenceDraw draw(sequence, scenario.redraw);
  World world;
  world.classes = scenario.class_names;
  world.warnings = scenario.notices;
  WorldFaults faults;
  const std::map<std::string, Material> materials = load_materials(scenario, faults);
  ScouredTerrain scoured = scoured_terrain(scenario);
  MeshLibrary own;
  add_objects(scenario, draw, materials, library == nullptr ? own : *library, scoured, world,
              faults);
  std::vector<VolumeParts> volumes = load_volumes(scenario, draw, faults);
  if (!faults.lines.empty()) {
    return Error{faults.usage ? ErrorKind::usage : ErrorKind::io, faults.lines};
  }
  const ParentTree tree = parent_tree(scenario);
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const bool stands = !tree.parent[i] && !scenario.objects[i].place;
    if (stands) carry_children(scenario, tree, i, world);
  }
  if (Status placed = place_objects(scenario, draw, tree, world); !placed) return placed.error();
  scour_terrain(scenario, scoured, world);
  for (const PointTargetSpec& spec : scenario.point_targets) {
    Instance& instance = add_instance(world, spec.name, spec.class_name);
    instance.kind = InstanceKind::point_target;
    instance.target_strength_db = spec.target_strength_db;
    world.point_targets.push_back({instance.id,
                                   {spec.position_m[0], spec.position_m[1], spec.position_m[2]},
                                   spec.target_strength_db});
  }
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    add_volume(scenario.volumes[i], std::move(volumes[i]), world);
  }
  return world;
}

}  // namespace ensonify
