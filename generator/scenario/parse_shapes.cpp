#include "scenario/parse.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

void parse_box(Faults& faults, const Value& map, ShapeSpec& shape) {
  BoxSpec box;
  if (!open_map(faults, map, {"size_m", "inside"})) return;
  read_numbers(faults, map, "size_m", kLength, box.size_m, Need::required);
  read_boolean(faults, map, "inside", box.inside);
  shape = box;
}

void parse_sphere(Faults& faults, const Value& map, ShapeSpec& shape) {
  SphereSpec sphere;
  if (!open_map(faults, map, {"radius_m", "inside"})) return;
  read_number(faults, map, "radius_m", kLength, sphere.radius_m, Need::required);
  read_boolean(faults, map, "inside", sphere.inside);
  shape = sphere;
}

void parse_cylinder(Faults& faults, const Value& map, ShapeSpec& shape) {
  CylinderSpec cylinder;
  if (!open_map(faults, map, {"radius_m", "height_m"})) return;
  read_number(faults, map, "radius_m", kLength, cylinder.radius_m, Need::required);
  read_number(faults, map, "height_m", kLength, cylinder.height_m, Need::required);
  shape = cylinder;
}

void parse_parts(Faults& faults, const Value& map, const MaterialNames& names,
                 std::vector<PartSpec>& parts) {
  if (map.node->kind != NodeKind::map) {
    add_fault(faults, map.place, map.path,
              "no map, accepted is a map of the file's parts to materials, as in {hull: steel}");
    return;
  }
  for (const Key& key : map.node->keys) {
    PartSpec& part = parts.emplace_back();
    part.part = key.text;
    if (is_name(faults, key, path_of(map, key.text))) {
      parse_material_name(faults, map, key.text, names, part.material);
    }
  }
}

void parse_mesh(const InputFolder& input, const Value& map, const MaterialNames& names,
                ShapeSpec& shape) {
  MeshSpec mesh;
  if (!open_map(input.faults, map, {"file", "scale", "normals", "reflectivity", "parts"})) return;
  parse_input_file(input, map, "file", {".obj", ".stl", ".ply", ".dae", ".glb", ".gltf"},
                   mesh.file);
  read_number(input.faults, map, "scale", kLength, mesh.scale);
  read_choice<bool>(input.faults, map, "normals", {{"face", false}, {"smooth", true}},
                    mesh.smooth_normals);
  read_choice<bool>(input.faults, map, "reflectivity",
                    {{"material", false}, {"vertex_color", true}}, mesh.vertex_reflectivity);
  if (const auto parts = child(map, "parts")) {
    parse_parts(input.faults, *parts, names, mesh.parts);
  }
  shape = mesh;
}

void parse_level_set(const InputFolder& input, const Value& map, ShapeSpec& shape) {
  LevelSetSpec level_set;
  if (!open_map(input.faults, map, {"file", "grid", "normals"})) return;
  parse_input_file(input, map, "file", {".vdb"}, level_set.file);
  read_text(input.faults, map, "grid", level_set.grid);
  read_choice<bool>(input.faults, map, "normals", {{"face", false}, {"smooth", true}},
                    level_set.smooth_normals);
  shape = level_set;
}

void parse_model(Faults& faults, const Value& map, ShapeSpec& shape) {
  ModelSpec model;
  if (!open_map(faults, map, {"kind", "size_m"})) return;
  read_choice<ModelKind>(faults, map, "kind", {kModelKinds.begin(), kModelKinds.end()}, model.kind,
                         Need::required);
  read_number(faults, map, "size_m", kLength, model.size_m, Need::required);
  shape = model;
}

}  // namespace

void parse_shape(const InputFolder& input, const Value& map, const MaterialNames& names,
                 ShapeSpec& shape) {
  const std::vector<std::string_view> kinds = {"box",  "sphere",      "cylinder", "plane",
                                               "mesh", "heightfield", "model",    "level_set"};
  if (!open_map(input.faults, map, kinds)) return;
  const auto kind = only_key_of(input.faults, map, kinds, "one of " + joined(kinds));
  if (!kind) return;
  const Value value = *child(map, *kind);
  if (*kind == "box") parse_box(input.faults, value, shape);
  if (*kind == "sphere") parse_sphere(input.faults, value, shape);
  if (*kind == "cylinder") parse_cylinder(input.faults, value, shape);
  if (*kind == "mesh") parse_mesh(input, value, names, shape);
  if (*kind == "heightfield") parse_heightfield(input, value, shape.emplace<HeightfieldSpec>());
  if (*kind == "level_set") parse_level_set(input, value, shape);
  if (*kind == "model") parse_model(input.faults, value, shape);
  if (*kind == "plane" && open_map(input.faults, value, {})) shape = PlaneSpec{};
}

}  // namespace ensonify
