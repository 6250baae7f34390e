// The water: sound speed, its profile, absorption; and what scatters in it.
#include <fmt/format.h>

#include "scenario/sections.h"
#include "scenario/tables.h"

namespace ensonify {

static void fields(Fields& f, SoundSpeedSpec& from) {
  f.number("temperature_c", from.temperature_c, from_to(-5, 40), kRequired);
  f.number("salinity_psu", from.salinity_psu, from_to(0, 45), kRequired);
  f.number("depth_m", from.depth_m, from_to(0, 12000), kRequired);
}

namespace {

constexpr NumberRange kStrength = from_to(-200, 60);
constexpr NumberRange kExtinction = from_to(0, 1e4);

// A number, or {from: {temperature_c, salinity_psu, depth_m}}.
void sound_speed_fields(Fields& f, WaterSpec& water) {
  const Node* given = f.peek("sound_speed_m_s");
  const bool from = f.writing() ? water.sound_speed_from.has_value()
                                : given != nullptr && given->kind == NodeKind::map;
  if (!from) {
    f.number("sound_speed_m_s", water.sound_speed_m_s, from_to(kMinSoundSpeed, kMaxSoundSpeed));
  } else if (f.begin("sound_speed_m_s")) {
    f.map("from", water.sound_speed_from, kRequired);
    f.end();
  }
}

void absorption_fields(Fields& f, WaterSpec& water) {
  constexpr std::string_view kKeys[] = {"fixed_db_m", "model"};
  const auto which =
      f.only_key(kKeys, std::holds_alternative<FixedAbsorptionSpec>(water.absorption) ? 0 : 1,
                 "fixed_db_m (dB/m) or model (francois_garrison, ainslie_mccolm)");
  FixedAbsorptionSpec fixed;
  SeaAbsorptionSpec model;
  if (f.writing() && which == 0u) fixed = std::get<FixedAbsorptionSpec>(water.absorption);
  if (f.writing() && which == 1u) model = std::get<SeaAbsorptionSpec>(water.absorption);
  const Rule of_model = useless_if(which == 0u, "beside fixed_db_m, accepted is either alone");
  if (which == 0u) f.number("fixed_db_m", fixed.db_m, from_to(0, 1000));
  if (which == 1u) {
    f.choice<AbsorptionModel>("model", model.model,
                              {{"francois_garrison", AbsorptionModel::francois_garrison},
                               {"ainslie_mccolm", AbsorptionModel::ainslie_mccolm}},
                              kRequired);
  }
  f.number("temperature_c", model.temperature_c, from_to(-5, 60), of_model);
  f.number("salinity_psu", model.salinity_psu, from_to(0, 100), of_model);
  f.number("ph", model.ph, from_to(5, 10), of_model);
  f.number("depth_m", model.depth_m, from_to(0, 12000), of_model);
  if (which == 0u) water.absorption = fixed;
  if (which == 1u) water.absorption = model;
}

void check_rows(FieldReader& reader, const ProfileSpec& profile) {
  if (profile.depth_m.size() != profile.sound_speed_m_s.size()) {
    reader.fault("sound_speed_m_s",
                 fmt::format("{} numbers beside {} of depth_m, accepted is one for "
                             "each",
                             profile.sound_speed_m_s.size(), profile.depth_m.size()));
  }
  const Value depths = *child(reader.map(), "depth_m");
  for (std::size_t i = 1; i < profile.depth_m.size(); ++i) {
    if (profile.depth_m[i] > profile.depth_m[i - 1]) continue;
    const Value wrong = item(depths, i);
    add_fault(reader.faults(), wrong.place, wrong.path,
              fmt::format("{} does not come after the {} before it, accepted are depths that rise",
                          profile.depth_m[i], profile.depth_m[i - 1]));
  }
}

}  // namespace

static void fields(Fields& f, ProfileSpec& profile) {
  const bool from_file = f.writing() ? !profile.file.empty() : f.peek("file") != nullptr;
  f.file("file", profile.file, {".csv"}, written_if(from_file));
  const ReadWatch watch(f);
  const auto column = [&](std::string_view key, const NumberRange& range,
                          std::vector<double>& values) {
    const std::string missing = "is a list of " + in_words(range, "number");
    const ListWords words{missing, "is one row and more", 1};
    return f.list(
        key, values, words,
        useless_if(from_file, "beside file, accepted is either the file or both lists", kRequired),
        [&](const std::string& at, double& value) { f.number(at, value, range); });
  };
  const bool depths = column("depth_m", from_to(kMinDepthM, kMaxDepthM), profile.depth_m);
  const bool speeds =
      column("sound_speed_m_s", from_to(kMinSoundSpeed, kMaxSoundSpeed), profile.sound_speed_m_s);
  if (depths && speeds && watch.is_well()) check_rows(*f.reader(), profile);
  f.number("surface_z_m", profile.surface_z_m, kPosition);
}

void fields(Fields& f, WaterSpec& water) {
  sound_speed_fields(f, water);
  f.map("profile", water.profile);
  if (f.begin("absorption")) {
    absorption_fields(f, water);
    f.end();
  }
}

static void fields(Fields& f, UniformVolumeSpec& uniform) {
  f.number("strength_db", uniform.strength_db, kStrength, kRequired);
  f.numbers("size_m", uniform.size_m, kLength);
}

static void fields(Fields& f, VdbVolumeSpec& vdb) {
  f.file("file", vdb.file, {".vdb"}, kRequired);
  f.text("grid", vdb.grid);
  f.number("strength_db", vdb.strength_db, kStrength, kRequired);
  f.number("extinction_db_m", vdb.extinction_db_m, kExtinction);
}

static void fields(Fields& f, PlumeSpec& plume) {
  const bool has_radius = f.number("radius_m", plume.radius_m, kLength, kRequired);
  const bool has_height = f.number("height_m", plume.height_m, kLength, kRequired);
  if (has_radius && has_height && plume.height_m > kMaxPlumeSlimness * plume.radius_m) {
    f.fault("height_m", fmt::format("more than {} times radius_m, accepted is a plume that is "
                                    "less slim",
                                    kMaxPlumeSlimness));
  }
  f.number("spread_deg", plume.spread_deg, from_to(0, 60));
  f.number("strength_db", plume.strength_db, kStrength, kRequired);
  f.number("extinction_db_m", plume.extinction_db_m, kExtinction);
}

static void fields(Fields& f, SchoolSpec& school) {
  f.numbers("size_m", school.size_m, kLength, kRequired);
  f.integer("fish", school.fish, 1, kMaxFish, kRequired);
  f.number("target_strength_db", school.target_strength_db, from_to(-300, 300), kRequired);
}

void fields(Fields& f, VolumeSpec& volume) {
  f.text("name", volume.name, kRequired);
  f.text("class", volume.class_name);
  const auto kind = f.one_of(volume.kind, {"uniform", "vdb", "plume", "school"});
  auto* uniform = kind ? std::get_if<UniformVolumeSpec>(&volume.kind) : nullptr;
  const bool is_school = std::holds_alternative<SchoolSpec>(volume.kind);
  double none = 0;
  f.number("extinction_db_m", uniform != nullptr ? uniform->extinction_db_m : none, kExtinction,
           useless_if(kind && uniform == nullptr,
                      is_school ? "on a school: fish do not attenuate"
                                : "here: it belongs among the keys of its kind"));
  const Node* given = f.peek("uniform");
  const bool may_end =
      given != nullptr && (given->kind != NodeKind::map || find(*given, "size_m") != nullptr);
  f.map("pose", volume.pose,
        useless_if(uniform != nullptr && !uniform->size_m && !may_end,
                   "on a uniform volume without size_m: it has no end"));
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
