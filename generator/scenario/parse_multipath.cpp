#include "scenario/parse.h"

namespace ensonify {
namespace {

// One mirror; none where it is not given.
void parse_flat(Faults& faults, const Value& multipath, const char* key,
                std::optional<FlatSurface>& flat) {
  const auto value = child(multipath, key);
  if (!value || !open_map(faults, *value, {"z_m", "reflection", "roughness_rms_m"})) return;
  FlatSurface& surface = flat.emplace();
  read_number(faults, *value, "z_m", from_to(-kMaxLengthM, kMaxLengthM), surface.z_m,
              Need::required);
  read_number(faults, *value, "reflection", from_to(-1, 1), surface.reflection, Need::required);
  read_number(faults, *value, "roughness_rms_m", from_to(0, 1), surface.roughness_rms_m);
}

}  // namespace

void parse_multipath(Faults& faults, const Value& value, Multipath& multipath) {
  if (!open_map(faults, value, {"surface", "bottom", "objects", "bounces"})) return;
  const std::size_t before = faults.found();
  parse_flat(faults, value, "surface", multipath.surface);
  parse_flat(faults, value, "bottom", multipath.bottom);
  read_boolean(faults, value, "objects", multipath.objects);
  read_integer(faults, value, "bounces", 1, kMaxBounces, multipath.bounces);
  if (faults.found() != before) return;
  const auto& [surface, bottom, objects, bounces] = multipath;
  if (!surface && !bottom && !objects) {
    add_fault(faults, value.place, value.path,
              "there is nothing to bounce off, accepted is surface, bottom or objects: true");
  }
  if (surface && bottom && !(bottom->z_m < surface->z_m)) {
    const Value below = child_or_empty(value, "bottom");
    add_fault(faults, below.place, path_of(below, "z_m"),
              "not below the surface, accepted is a bottom whose z_m is less than surface.z_m");
  }
}

void parse_multipath_mask(Faults& faults, const Value& root, Scenario& scenario) {
  OutputSelection& selection = scenario.output.selection;
  const bool pictures = selection.polar || selection.cartesian;
  selection.multipath = scenario.multipath && pictures;
  const Value output = child_or_empty(root, "output");
  if (output.node->kind != NodeKind::map) return;
  const auto given = child(output, "multipath");
  if (!given || !selection.pings) return;
  const auto map = read_switch(faults, output, "multipath", selection.multipath);
  if (map) open_map(faults, *map, {});
  if (!selection.multipath || (scenario.multipath && pictures)) return;
  add_fault(faults, given->place, given->path,
            pictures ? "nothing bounces, accepted with multipath"
                     : "there are no pictures for it, accepted with polar or cartesian");
}

}  // namespace ensonify
