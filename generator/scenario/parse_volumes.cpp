#include "scenario/parse.h"

namespace ensonify {

void parse_volumes(Faults& faults, const Value& value, std::vector<VolumeSpec>& volumes) {
  if (!open_list(faults, value)) return;
  volumes.resize(value.node->items.size());
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    const Value map = item(value, i);
    VolumeSpec& volume = volumes[i];
    if (!open_map(faults, map, {"name", "class", "uniform"})) continue;
    read_text(faults, map, "name", volume.name, Need::required);
    read_text(faults, map, "class", volume.class_name);
    const Value uniform = child_or_empty(map, "uniform");
    if (!open_map(faults, uniform, {"strength_db"})) continue;
    read_number(faults, uniform, "strength_db", from_to(-200, 60), volume.strength_db,
                Need::required);
  }
}

}  // namespace ensonify
