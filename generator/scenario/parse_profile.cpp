#include <algorithm>

#include <fmt/format.h>

#include "scenario/parse.h"
#include "scenario/tables.h"

namespace ensonify {
namespace {

// A list of one number and more.
bool read_column(Faults& faults, const Value& profile, std::string_view key,
                 const NumberRange& range, std::vector<double>& out) {
  const auto list = child(profile, key);
  if (!list) {
    add_fault(faults, profile.place, path_of(profile, key),
              fmt::format("missing, accepted is a list of {}", in_words(range, "number")));
    return false;
  }
  if (!open_list(faults, *list)) return false;
  out.resize(list->node->items.size());
  if (!out.empty()) return read_numbers_of(faults, *list, range, out.data(), out.size());
  add_fault(faults, list->place, list->path, "empty, accepted is one row and more");
  return false;
}

void check_rows(Faults& faults, const Value& value, const ProfileSpec& profile) {
  const Value depths = *child(value, "depth_m"), speeds = *child(value, "sound_speed_m_s");
  if (profile.depth_m.size() != profile.sound_speed_m_s.size()) {
    add_fault(faults, speeds.place, speeds.path,
              fmt::format("{} numbers beside {} of depth_m, accepted is one for each",
                          profile.sound_speed_m_s.size(), profile.depth_m.size()));
  }
  for (std::size_t i = 1; i < profile.depth_m.size(); ++i) {
    if (profile.depth_m[i] > profile.depth_m[i - 1]) continue;
    const Value wrong = item(depths, i);
    add_fault(faults, wrong.place, wrong.path,
              fmt::format("{} does not come after the {} before it, accepted are depths that rise",
                          profile.depth_m[i], profile.depth_m[i - 1]));
  }
}

}  // namespace

void parse_profile(const InputFolder& input, const Value& value, ProfileSpec& profile) {
  Faults& faults = input.faults;
  if (!open_map(faults, value, {"file", "depth_m", "sound_speed_m_s", "surface_z_m"})) return;
  read_number(faults, value, "surface_z_m", from_to(-kMaxLengthM, kMaxLengthM),
              profile.surface_z_m);
  if (child(value, "file")) {
    refuse_useless(faults, value, {"depth_m", "sound_speed_m_s"},
                   "beside file, accepted is either the file or both lists");
    parse_input_file(input, value, "file", {".csv"}, profile.file);
    return;
  }
  const bool depths =
      read_column(faults, value, "depth_m", from_to(kMinDepthM, kMaxDepthM), profile.depth_m);
  const bool speeds = read_column(faults, value, "sound_speed_m_s",
                                  from_to(kMinSoundSpeed, kMaxSoundSpeed), profile.sound_speed_m_s);
  if (depths && speeds) check_rows(faults, value, profile);
}

void check_profile_conflicts(Faults& faults, const Value& root, const Scenario& scenario) {
  if (!scenario.water.profile) return;
  const auto refuse = [&](std::optional<Value> value, const std::string& text) {
    const Value at = value ? *value : root;
    add_fault(faults, at.place, at.path, text);
  };
  if (scenario.multipath) {
    refuse(child(root, "multipath"),
           "bounces are not worked out along bent rays: accepted is multipath or water.profile");
  }
  if (scenario.motion_within_ping) {
    refuse(child(root, "motion_within_ping"),
           "the sonar's motion is not followed along bent rays: accepted is motion_within_ping or "
           "water.profile");
  }
  if (scenario.scattering.speckle == SpeckleMode::surface) {
    const auto scattering = child(root, "scattering");
    refuse(scattering ? child(*scattering, "speckle") : scattering,
           "scatterers fixed on surfaces are not looked for along bent rays: accepted beside "
           "water.profile are per_ping and per_ray");
  }
  if (const auto materials = child(root, "materials")) {
    for (const MaterialSpec& material : scenario.materials) {
      if (!std::holds_alternative<KirchhoffSpec>(material.coherent)) continue;
      const auto value = child(*materials, material.name);
      refuse(value ? child(*value, "coherent") : value,
             "mirrors are not worked out along bent rays: kirchhoff cannot stand beside "
             "water.profile, accepted is another model, none, or no profile");
    }
  }
  const auto volumes = child(root, "volumes");
  for (std::size_t i = 0; volumes && i < scenario.volumes.size(); ++i) {
    const VolumeSpec& volume = scenario.volumes[i];
    const auto* uniform = std::get_if<UniformVolumeSpec>(&volume.kind);
    const bool open = uniform != nullptr && !uniform->size_m;
    if (open || std::holds_alternative<SchoolSpec>(volume.kind)) continue;
    refuse(item(*volumes, i),
           "volumes with bounds are not looked at along bent rays: accepted beside water.profile "
           "are uniform ones without size_m, and schools");
  }
}

}  // namespace ensonify
