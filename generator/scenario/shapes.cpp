// The keys of the shapes of objects, including terrain.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "scenario/sections.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr double kMaxVertices = 64e6;

// Summing this many waves takes 1 GiB.
constexpr double kMaxPeriodCells = 1 << 26;

// Coarser ripples would become zigzags.
constexpr double kMinCellsPerRipple = 4;

// Below the trochoid's cusp at 1/pi; sand steeper than 0.16 would slide.
constexpr double kMaxSteepness = 0.3;

int cells_along(double size_m, double cell_m) {
  return std::max(1, static_cast<int>(std::lround(size_m / cell_m)));
}

constexpr std::string_view kMeshNormals =
    "face: normals of the faces; smooth: interpolated between the vertices, and a body with a "
    "specular echo becomes round";

void normals_field(Fields& f, std::string_view meaning, bool& smooth) {
  f.choice<bool>({"normals", "Normals", meaning}, smooth, {{"face", false}, {"smooth", true}});
}

// A number, or a list of one number for each axis.
void scale_field(Fields& f, std::array<double, 3>& scale) {
  const KeyText text = {
      "scale", "Scale",
      "Factor applied to all lengths in the file, or [x, y, z]: one for each axis"};
  const Node* given = f.peek("scale");
  const bool is_list = given != nullptr && given->kind == NodeKind::list;
  const bool is_even = scale[0] == scale[1] && scale[0] == scale[2];
  if (is_list || (f.writing() && !is_even)) {
    f.numbers(text, scale, kLength);
  } else if (double all = scale[0]; f.number(text, all, kLength)) {
    scale = {all, all, all};
  }
}

void parts_fields(Fields& f, std::vector<PartSpec>& parts) {
  std::vector<std::string> names;
  for (const PartSpec& part : parts) names.push_back(part.part);
  const std::string_view what =
      "not a map; expected a map from parts of the file to materials, such as {hull: steel}";
  if (!f.begin({"parts", "Materials of parts",
                "Materials of parts of the mesh, by the names that the file gives them; the other "
                "parts have the object's material; left out: none"},
               NamesBranch{names, what}, written_if(!parts.empty()))) {
    return;
  }
  parts.resize(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    f.material(names[i], parts[i].material);
    parts[i].part = std::move(names[i]);
  }
  f.end();
}

void ripple_fields(Fields& f, RippleSpec& ripple, double cell_m) {
  const bool has_height =
      f.number({"height_m", "Height", "Height from trough to crest, at most 0.3 of wavelength_m"},
               ripple.height_m, from_to(0, 1e3), kRequired);
  const bool has_length =
      f.number({"wavelength_m", "Wavelength", "Distance between crests, at least 4 times cell_m"},
               ripple.wavelength_m, kLength, kRequired);
  f.number({"direction_deg", "Direction", "Direction of the wave vector, from x toward y"},
           ripple.direction_deg, from_to(-360, 360));
  if (!has_length) return;
  if (ripple.wavelength_m < kMinCellsPerRipple * cell_m) {
    f.fault("wavelength_m",
            fmt::format(
                "{} m is less than {} cells of {} m; expected longer ripples or a smaller cell_m",
                ripple.wavelength_m, kMinCellsPerRipple, cell_m));
  }
  if (has_height && ripple.height_m > kMaxSteepness * ripple.wavelength_m) {
    f.fault("height_m", fmt::format("{} m is too steep for a wavelength of {} m; expected a height "
                                    "up to {} times the wavelength",
                                    ripple.height_m, ripple.wavelength_m, kMaxSteepness));
  }
}

void check_size(Fields& f, const HeightfieldSpec& field) {
  const auto refuse = [&](const std::string& trouble) {
    f.fault("cell_m", trouble + ", which needs larger cells or a smaller size_m");
  };
  const auto [size_x, size_y] = field.size_m;
  const double vertices = (size_x / field.cell_m + 1) * (size_y / field.cell_m + 1);
  if (vertices > kMaxVertices) {
    refuse(fmt::format("{} m over {} m x {} m makes {:.4g} vertices; expected at most {:.0f}",
                       field.cell_m, size_x, size_y, vertices, kMaxVertices));
    return;
  }
  if (!field.roughness) return;
  const auto [period_x, period_y] = roughness_period(field);
  if (static_cast<double>(period_x) * static_cast<double>(period_y) > kMaxPeriodCells) {
    refuse(fmt::format(
        "{} m for roughness over {} m x {} m makes {} x {} waves; expected at most {:.0f}",
        field.cell_m, size_x, size_y, period_x, period_y, kMaxPeriodCells));
  }
}

}  // namespace

static constexpr KeyText kInwardText = {
    "inward_facing", "Inward facing",
    "Whether the shape is a room, seen from inside; from outside, sound passes through its walls"};

static void fields(Fields& f, BoxSpec& box) {
  f.numbers({"size_m", "Size", "[x, y, z]"}, box.size_m, kLength, kRequired);
  f.renamed("inside", "inward_facing");
  f.boolean(kInwardText, box.inside);
}

static void fields(Fields& f, SphereSpec& sphere) {
  f.number({"radius_m", "Radius", "Radius of the sphere"}, sphere.radius_m, kLength, kRequired);
  f.renamed("inside", "inward_facing");
  f.boolean(kInwardText, sphere.inside);
}

static void fields(Fields& f, CylinderSpec& cylinder) {
  f.number({"radius_m", "Radius", "Radius of the cylinder"}, cylinder.radius_m, kLength, kRequired);
  f.number({"height_m", "Height", "Height along z"}, cylinder.height_m, kLength, kRequired);
}

static void fields(Fields&, PlaneSpec&) {}

// Where the factor on the material's reflectivity comes from.
static void mesh_reflectivity_fields(Fields& f, MeshSpec& mesh) {
  constexpr std::string_view kWords[] = {"material", "vertex_color", "texture"};
  std::size_t from = mesh.vertex_reflectivity ? 1 : 0;
  if (!mesh.texture_file.empty()) from = 2;
  const ReadWatch watch(f);
  f.word({"reflectivity", "Reflectivity",
          "material: that of the material alone; vertex_color: that of the material times the "
          "brightness of the mesh's vertex colors; texture: that of the material times the "
          "brightness of the image texture_file at the mesh's texture coordinates"},
         kWords, from);
  mesh.vertex_reflectivity = from == 1;
  const bool has_image = from == 2, is_known = f.reader() == nullptr || watch.is_well();
  const bool read = f.file(
      {"texture_file", "Texture file",
       "PNG file; its mean of red, green and blue over the highest value is a factor on the "
       "material's reflectivity, bilinear between pixels, v up, repeated beyond 0 to 1; needed "
       "with reflectivity: texture; left out: none"},
      mesh.texture_file, {".png"},
      useless_if(!has_image && is_known, "without reflectivity: texture", {.has_default = false}));
  if (has_image && !read && watch.is_well()) {
    f.fault("texture_file", "missing; expected a .png file, as reflectivity is texture");
  }
}

static void fields(Fields& f, MeshSpec& mesh) {
  f.file({"file", "Mesh file", "OBJ, STL, PLY, DAE, GLB, or glTF with embedded buffers"}, mesh.file,
         {".obj", ".stl", ".ply", ".dae", ".glb", ".gltf"}, kRequired);
  scale_field(f, mesh.scale);
  normals_field(f, kMeshNormals, mesh.smooth_normals);
  mesh_reflectivity_fields(f, mesh);
  parts_fields(f, mesh.parts);
}

static void fields(Fields& f, ModelSpec& model) {
  f.choice<ModelKind>({"kind", "Kind", "Kind of object"}, model.kind, kModelKinds, kRequired);
  f.number({"size_m", "Size", "Longest edge of the bounding box"}, model.size_m, kLength,
           kRequired);
}

static void fields(Fields& f, LevelSetSpec& level_set) {
  f.file({"file", "Level-set file", "OpenVDB file (.vdb)"}, level_set.file, {".vdb"}, kRequired);
  f.text({"grid", "Grid", "Name of the grid in the file; left out: the only grid of the file"},
         level_set.grid, written_if(!level_set.grid.empty(), {.has_default = false}));
  normals_field(f, kMeshNormals, level_set.smooth_normals);
}

static void fields(Fields& f, RoughnessSpec& roughness) {
  f.number({"rms_m", "Rms height", "Rms of the heights over waves of all lengths"}, roughness.rms_m,
           from_to(0, 1e3), kRequired);
  // At exponent 2 the mean square of a surface with ever shorter waves is unbounded.
  f.number({"exponent", "Exponent",
            "γ, the exponent of the power-law spectrum; sea floors have 2.5 to 4"},
           roughness.exponent, above_up_to(2, 8));
  f.number(
      {"outer_scale_m", "Outer scale", "Wavelength above which the spectrum no longer increases"},
      roughness.outer_scale_m, kLength);
}

// These keys convert the values of a file to heights.
static void height_fields(Fields& f, HeightfieldSpec& field, const Rule& rule) {
  f.number({"height_scale", "Height scale",
            "Factor applied to the values of the file: height = height_scale · value + "
            "height_offset_m"},
           field.height_scale, from_to(-1e6, 1e6), rule);
  f.number({"height_offset_m", "Height offset", "Added to the scaled values of the file"},
           field.height_offset_m, kPosition, rule);
}

static void ripples_field(Fields& f, HeightfieldSpec& field, const Rule& rule) {
  f.list({"ripples", "Ripples",
          "Trains of sand ripples: trochoids with sharp crests and wide troughs; left out: none"},
         field.ripples, {}, rule, [&](const std::string& at, RippleSpec& ripple) {
           if (!f.begin(at)) return;
           ripple_fields(f, ripple, field.cell_m);
           f.end();
         });
}

static bool size_field(Fields& f, HeightfieldSpec& field) {
  return f.numbers(
      {"size_m", "Size", "[x, y] of a synthetic seabed, rounded to whole cells; in place of file"},
      field.size_m, kLength, kRequired);
}

static bool height_file_field(Fields& f, HeightfieldSpec& field) {
  return f.file({"file", "Height file", "File of heights, .npy, .png or .asc; in place of size_m"},
                field.file, {".npy", ".png", ".asc"}, kRequired);
}

void fields(Fields& f, HeightfieldSpec& field) {
  constexpr std::string_view kSources[] = {"file", "size_m"};
  const auto source = f.only_key(kSources, field.file.empty() ? 1 : 0,
                                 "either the file of heights or the size_m of a synthetic seabed");
  const bool from_file = source == 0u, made = source == 1u;
  const bool found = from_file && height_file_field(f, field);
  const bool has_size = made && size_field(f, field);
  const bool own_cell = from_file && equals_ignoring_case(field.file.extension().string(), ".asc");
  const bool has_cell = f.number(
      {"cell_m", "Cell size",
       "Distance between neighboring grid points; needed except with an .asc file; left "
       "out: that of the .asc file"},
      field.cell_m, kLength,
      useless_if(own_cell, "with an .asc file, which states its own cell size",
                 {.need = found || made ? Need::required : Need::optional, .has_default = false}));
  height_fields(f, field, useless_if(made, "without a file"));
  f.map({"roughness", "Roughness", "Random heights with a power-law spectrum; left out: none"},
        field.roughness, useless_if(from_file, "with a file"));
  if (has_size && has_cell) check_size(f, field);
  ripples_field(f, field, useless_if(from_file, "with a file", written_if(!field.ripples.empty())));
  normals_field(f,
                "face: normals of the triangles; smooth: from central differences between heights",
                field.smooth_normals);
  f.file({"reflectivity_map", "Reflectivity map",
          ".npy or .png file with a factor on the material's reflectivity; left out: none"},
         field.reflectivity_map, {".npy", ".png"},
         written_if(!field.reflectivity_map.empty(), {.has_default = false}));
  cover_fields(f, field);
}

void fields(Fields& f, ShapeSpec& shape) {
  f.one_of(shape,
           {{{"box", "Box", "A box centered at the origin"},
             {"sphere", "Sphere", "A sphere centered at the origin"},
             {"cylinder", "Cylinder",
              "A cylinder around z, centered at the origin and closed by two discs"},
             {"plane", "Plane", "The infinite plane z = 0, visible from both sides: {plane: {}}"},
             {"mesh", "Mesh", "A surface from a file"},
             {"heightfield", "Terrain",
              "Heights over a regular grid centered at the origin, from a file or synthetic"},
             {"model", "Model", "A built-in everyday object that rests on z = 0"},
             {"level_set", "Level set", "The zero surface of an OpenVDB level set"}}});
}

std::array<int, 2> vertices_along(const HeightfieldSpec& field) {
  return {cells_along(field.size_m[0], field.cell_m) + 1,
          cells_along(field.size_m[1], field.cell_m) + 1};
}

std::array<std::int64_t, 2> roughness_period(const HeightfieldSpec& field) {
  const std::array<int, 2> vertices = vertices_along(field);
  const double outer_m = field.roughness ? field.roughness->outer_scale_m : 0;
  const double least = std::min(outer_m, std::max(field.size_m[0], field.size_m[1])) / field.cell_m;
  std::array<std::int64_t, 2> period{2, 2};
  for (int side = 0; side < 2; ++side) {
    while (period[side] < vertices[side] || static_cast<double>(period[side]) < least) {
      period[side] *= 2;
    }
  }
  return period;
}

}  // namespace ensonify
