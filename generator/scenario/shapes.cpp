// Shapes of objects, terrain among them.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "scenario/sections.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr double kMaxVertices = 64e6;

// 1 GiB while the waves are summed.
constexpr double kMaxPeriodCells = 1 << 26;

// Coarser ones would be drawn as zigzags.
constexpr double kMinCellsPerRipple = 4;

// Under the trochoid's cusp at 1/pi; sand of more than 0.16 would slide.
constexpr double kMaxSteepness = 0.3;

int cells_along(double size_m, double cell_m) {
  return std::max(1, static_cast<int>(std::lround(size_m / cell_m)));
}

void normals_field(Fields& f, bool& smooth) {
  f.choice<bool>("normals", smooth, {{"face", false}, {"smooth", true}});
}

void parts_fields(Fields& f, std::vector<PartSpec>& parts) {
  std::vector<std::string> names;
  for (const PartSpec& part : parts) names.push_back(part.part);
  const std::string_view what =
      "no map, accepted is a map of the file's parts to materials, as in {hull: steel}";
  if (!f.begin("parts", NamesBranch{names, what}, written_if(!parts.empty()))) return;
  parts.resize(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    f.material(names[i], parts[i].material);
    parts[i].part = std::move(names[i]);
  }
  f.end();
}

void ripple_fields(Fields& f, RippleSpec& ripple, double cell_m) {
  const bool has_height = f.number("height_m", ripple.height_m, from_to(0, 1e3), kRequired);
  const bool has_length = f.number("wavelength_m", ripple.wavelength_m, kLength, kRequired);
  f.number("direction_deg", ripple.direction_deg, from_to(-360, 360));
  if (!has_length) return;
  if (ripple.wavelength_m < kMinCellsPerRipple * cell_m) {
    f.fault("wavelength_m",
            fmt::format("{} m is less than {} cells of {} m, accepted are longer ripples or a "
                        "smaller cell_m",
                        ripple.wavelength_m, kMinCellsPerRipple, cell_m));
  }
  if (has_height && ripple.height_m > kMaxSteepness * ripple.wavelength_m) {
    f.fault("height_m",
            fmt::format("{} m is too steep for a wavelength of {} m, accepted are heights up to "
                        "{} of it",
                        ripple.height_m, ripple.wavelength_m, kMaxSteepness));
  }
}

void check_size(Fields& f, const HeightfieldSpec& field) {
  const auto refuse = [&](const std::string& trouble) {
    f.fault("cell_m", trouble + "; take larger cells or a smaller size_m");
  };
  const auto [size_x, size_y] = field.size_m;
  const double vertices = (size_x / field.cell_m + 1) * (size_y / field.cell_m + 1);
  if (vertices > kMaxVertices) {
    refuse(fmt::format("{} m over {} m x {} m makes {:.4g} vertices, accepted are {:.0f} at most",
                       field.cell_m, size_x, size_y, vertices, kMaxVertices));
    return;
  }
  if (!field.roughness) return;
  const auto [period_x, period_y] = roughness_period(field);
  if (static_cast<double>(period_x) * static_cast<double>(period_y) > kMaxPeriodCells) {
    refuse(
        fmt::format("{} m for roughness over {} m x {} m makes {} x {} waves, accepted are "
                    "{:.0f} at most",
                    field.cell_m, size_x, size_y, period_x, period_y, kMaxPeriodCells));
  }
}

}  // namespace

static void fields(Fields& f, BoxSpec& box) {
  f.numbers("size_m", box.size_m, kLength, kRequired);
  f.boolean("inside", box.inside);
}

static void fields(Fields& f, SphereSpec& sphere) {
  f.number("radius_m", sphere.radius_m, kLength, kRequired);
  f.boolean("inside", sphere.inside);
}

static void fields(Fields& f, CylinderSpec& cylinder) {
  f.number("radius_m", cylinder.radius_m, kLength, kRequired);
  f.number("height_m", cylinder.height_m, kLength, kRequired);
}

static void fields(Fields&, PlaneSpec&) {}

static void fields(Fields& f, MeshSpec& mesh) {
  f.file("file", mesh.file, {".obj", ".stl", ".ply", ".dae", ".glb", ".gltf"}, kRequired);
  f.number("scale", mesh.scale, kLength);
  normals_field(f, mesh.smooth_normals);
  f.choice<bool>("reflectivity", mesh.vertex_reflectivity,
                 {{"material", false}, {"vertex_color", true}});
  parts_fields(f, mesh.parts);
}

static void fields(Fields& f, ModelSpec& model) {
  f.choice<ModelKind>("kind", model.kind, kModelKinds, kRequired);
  f.number("size_m", model.size_m, kLength, kRequired);
}

static void fields(Fields& f, LevelSetSpec& level_set) {
  f.file("file", level_set.file, {".vdb"}, kRequired);
  f.text("grid", level_set.grid, written_if(!level_set.grid.empty()));
  normals_field(f, level_set.smooth_normals);
}

static void fields(Fields& f, RoughnessSpec& roughness) {
  f.number("rms_m", roughness.rms_m, from_to(0, 1e3), kRequired);
  // At 2 the mean square of a surface with ever shorter waves has no limit.
  f.number("exponent", roughness.exponent, above_up_to(2, 8));
  f.number("outer_scale_m", roughness.outer_scale_m, kLength);
}

void fields(Fields& f, HeightfieldSpec& field) {
  constexpr std::string_view kSources[] = {"file", "size_m"};
  const auto source = f.only_key(kSources, field.file.empty() ? 1 : 0,
                                 "a file of heights or the size_m of a made one");
  const bool from_file = source == 0u, made = source == 1u;
  const bool found = from_file && f.file("file", field.file, {".npy", ".png", ".asc"}, kRequired);
  const bool has_size = made && f.numbers("size_m", field.size_m, kLength, kRequired);
  const bool own_cell = from_file && equals_ignoring_case(field.file.extension().string(), ".asc");
  const bool has_cell =
      f.number("cell_m", field.cell_m, kLength,
               useless_if(own_cell, "beside an .asc file, which brings its own",
                          {.need = found || made ? Need::required : Need::optional}));
  const Rule of_file = useless_if(made, "without a file");
  f.number("height_scale", field.height_scale, from_to(-1e6, 1e6), of_file);
  f.number("height_offset_m", field.height_offset_m, kPosition, of_file);
  const Rule of_made = useless_if(from_file, "beside a file");
  f.map("roughness", field.roughness, of_made);
  if (has_size && has_cell) check_size(f, field);
  f.list("ripples", field.ripples, {},
         useless_if(from_file, "beside a file", written_if(!field.ripples.empty())),
         [&](const std::string& at, RippleSpec& ripple) {
           if (!f.begin(at)) return;
           ripple_fields(f, ripple, field.cell_m);
           f.end();
         });
  normals_field(f, field.smooth_normals);
  f.file("reflectivity_map", field.reflectivity_map, {".npy", ".png"},
         written_if(!field.reflectivity_map.empty()));
}

void fields(Fields& f, ShapeSpec& shape) {
  f.one_of(shape,
           {"box", "sphere", "cylinder", "plane", "mesh", "heightfield", "model", "level_set"});
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
