// The keys of `output` that select files of the scene: distance field, meshes, height map.
#include <fmt/format.h>

#include "scenario/sections.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr int kMaxSdfBand = 100;

// For a switch without its map of options.
void option_is_missing(Fields& f, const char* key, const char* option, const char* example) {
  const FieldReader* reader = f.reader();
  if (reader == nullptr) return;
  const Value value = *child(reader->map(), key);
  add_fault(reader->faults(), value.place, path_of(value, option),
            fmt::format("missing; expected a map with it, such as {{{}: {}}}", option, example));
}

void sdf_fields(Fields& f, std::optional<SdfGrid>& sdf) {
  bool on = sdf.has_value();
  const bool has_options =
      f.begin_switch({"sdf", "Distance field",
                      "Signed distance field of the scene as an OpenVDB file; a map of options "
                      "switches it on"},
                     on, written_if(on));
  if (!on) return;
  if (!sdf) sdf.emplace();
  if (has_options) {
    f.number({"voxel_m", "Voxel size", "Edge of a voxel"}, sdf->voxel_m,
             above_up_to(0, kMaxLengthM), kRequired);
    f.integer(
        {"band_voxels", "Band", "Voxels with distances on either side of a surface", "voxels"},
        sdf->band_voxels, 1, kMaxSdfBand);
    f.end();
  } else {
    option_is_missing(f, "sdf", "voxel_m", "0.05");
  }
}

void height_map_fields(Fields& f, std::optional<HeightMap>& map) {
  bool on = map.has_value();
  const bool has_options =
      f.begin_switch({"height_map", "Height map",
                      "Heights of the highest surfaces on a grid over the region that the fans of "
                      "a sequence reach; a map of options switches it on"},
                     on, written_if(on));
  if (!on) return;
  if (!map) map.emplace();
  if (has_options) {
    f.number({"spacing_m", "Spacing", "Distance of neighboring points"}, map->spacing_m,
             above_up_to(0, kMaxLengthM), kRequired);
    f.end();
  } else {
    option_is_missing(f, "height_map", "spacing_m", "0.1");
  }
}

}  // namespace

void scene_file_fields(Fields& f, OutputSpec& output) {
  sdf_fields(f, output.sdf);
  f.toggle({"world", "World meshes",
            "Surfaces of the scene at the first ping as triangle meshes, in a PLY and a glTF file"},
           output.selection.world, written_if(output.selection.world));
  height_map_fields(f, output.height_map);
}

}  // namespace ensonify
