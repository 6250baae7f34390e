#include <fmt/format.h>

#include "scenario/parse.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

constexpr NumberRange kStrength = from_to(-200, 60);
constexpr NumberRange kExtinction = from_to(0, 1e4);

// The extinction of a uniform volume stands beside it.
void parse_uniform(Faults& faults, const Value& volume, const Value& map, VolumeKindSpec& kind) {
  UniformVolumeSpec uniform;
  if (!open_map(faults, map, {"strength_db", "size_m"})) return;
  read_number(faults, map, "strength_db", kStrength, uniform.strength_db, Need::required);
  std::array<double, 3> size_m{};
  if (read_numbers(faults, map, "size_m", kLength, size_m)) uniform.size_m = size_m;
  read_number(faults, volume, "extinction_db_m", kExtinction, uniform.extinction_db_m);
  if (!uniform.size_m && !child(map, "size_m")) {
    refuse_useless(faults, volume, {"pose"}, "on a uniform volume without size_m: it has no end");
  }
  kind = uniform;
}

void parse_vdb(const InputFolder& input, const Value& map, VolumeKindSpec& kind) {
  VdbVolumeSpec vdb;
  if (!open_map(input.faults, map, {"file", "grid", "strength_db", "extinction_db_m"})) return;
  parse_input_file(input, map, "file", {".vdb"}, vdb.file);
  read_text(input.faults, map, "grid", vdb.grid);
  read_number(input.faults, map, "strength_db", kStrength, vdb.strength_db, Need::required);
  read_number(input.faults, map, "extinction_db_m", kExtinction, vdb.extinction_db_m);
  kind = vdb;
}

void parse_plume(Faults& faults, const Value& map, VolumeKindSpec& kind) {
  PlumeSpec plume;
  if (!open_map(faults, map,
                {"radius_m", "height_m", "spread_deg", "strength_db", "extinction_db_m"})) {
    return;
  }
  const bool sized =
      read_number(faults, map, "radius_m", kLength, plume.radius_m, Need::required) &&
      read_number(faults, map, "height_m", kLength, plume.height_m, Need::required);
  if (sized && plume.height_m > kMaxPlumeSlimness * plume.radius_m) {
    const Value height = *child(map, "height_m");
    add_fault(faults, height.place, height.path,
              fmt::format("more than {} times radius_m, accepted is a plume that is less slim",
                          kMaxPlumeSlimness));
  }
  read_number(faults, map, "spread_deg", from_to(0, 60), plume.spread_deg);
  read_number(faults, map, "strength_db", kStrength, plume.strength_db, Need::required);
  read_number(faults, map, "extinction_db_m", kExtinction, plume.extinction_db_m);
  kind = plume;
}

void parse_school(Faults& faults, const Value& map, VolumeKindSpec& kind) {
  SchoolSpec school;
  if (!open_map(faults, map, {"size_m", "fish", "target_strength_db"})) return;
  read_numbers(faults, map, "size_m", kLength, school.size_m, Need::required);
  read_integer(faults, map, "fish", 1, kMaxFish, school.fish, Need::required);
  read_number(faults, map, "target_strength_db", from_to(-300, 300), school.target_strength_db,
              Need::required);
  kind = school;
}

void parse_volume(const InputFolder& input, const Value& map, VolumeSpec& volume) {
  Faults& faults = input.faults;
  const std::vector<std::string_view> kinds = {"uniform", "vdb", "plume", "school"};
  if (!open_map(
          faults, map,
          {"name", "class", "uniform", "vdb", "plume", "school", "pose", "extinction_db_m"})) {
    return;
  }
  read_text(faults, map, "name", volume.name, Need::required);
  read_text(faults, map, "class", volume.class_name);
  if (const auto pose = child(map, "pose"); pose && open_map(faults, *pose, kPoseKeys)) {
    parse_pose(faults, *pose, volume.pose);
  }
  const auto kind = only_key_of(faults, map, kinds, "one of " + joined(kinds));
  if (!kind) return;
  const Value value = *child(map, *kind);
  if (*kind == "uniform") return parse_uniform(faults, map, value, volume.kind);
  refuse_useless(faults, map, {"extinction_db_m"},
                 *kind == "school" ? "on a school: fish do not attenuate"
                                   : "here: it belongs among the keys of its kind");
  if (*kind == "vdb") parse_vdb(input, value, volume.kind);
  if (*kind == "plume") parse_plume(faults, value, volume.kind);
  if (*kind == "school") parse_school(faults, value, volume.kind);
}

}  // namespace

void parse_volumes(const InputFolder& input, const Value& value, std::vector<VolumeSpec>& volumes) {
  if (!open_list(input.faults, value)) return;
  volumes.resize(value.node->items.size());
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    parse_volume(input, item(value, i), volumes[i]);
  }
}

}  // namespace ensonify
