// The keys of the water: sound speed and its profile, absorption, and scattering volumes.
#include <algorithm>
#include <iterator>
#include <optional>

#include <fmt/format.h>

#include "acoustics/propagation.h"
#include "scenario/sections.h"
#include "scenario/tables.h"

namespace ensonify {

static constexpr NumberRange kTemperature = from_to(-5, 40), kSalinity = from_to(0, 45);

static void fields(Fields& f, SoundSpeedSpec& from) {
  f.number({"temperature_c", "Temperature", "Temperature of the water"}, from.temperature_c,
           kTemperature, kRequired);
  f.number({"salinity_psu", "Salinity", "Salinity of the water"}, from.salinity_psu, kSalinity,
           kRequired);
  f.number({"depth_m", "Depth", "Depth below the surface"}, from.depth_m, from_to(0, 12000),
           kRequired);
}

namespace {

constexpr NumberRange kStrength = from_to(-200, 60);
constexpr NumberRange kExtinction = from_to(0, 1e4);

constexpr KeyText kSoundSpeedText = {
    "sound_speed_m_s", "Sound speed",
    "A number, or {from: {temperature_c, salinity_psu, depth_m}}; with a profile, the value that "
    "the instrument assumes; left out: from water.temperature_c and the keys next to it if they "
    "are given, else 1500"};

// The keys that describe the water once. The resolved text has what follows from them in their
// place: sound speed, absorption and density.
std::optional<SeaAbsorptionSpec> description_fields(Fields& f) {
  constexpr std::string_view kKeys[] = {"temperature_c", "salinity_psu", "ph", "depth_m"};
  FieldReader* reader = f.reader();
  const bool is_given = std::any_of(std::begin(kKeys), std::end(kKeys), [&](std::string_view key) {
    return reader != nullptr && reader->peek(key) != nullptr;
  });
  SeaAbsorptionSpec described;
  const Rule unwritten{.written = false, .has_default = false};
  Rule both = unwritten;
  if (is_given) both.need = Need::required;
  f.number({kKeys[0], "Temperature",
            "Temperature of the water, from which sound speed, absorption and density follow as "
            "far as they are left out; needs salinity_psu; left out: not described"},
           described.temperature_c, kTemperature, both);
  f.number({kKeys[1], "Salinity",
            "Salinity of the water, 0 for fresh water and about 35 for the sea; needs "
            "temperature_c; left out: not described"},
           described.salinity_psu, kSalinity, both);
  f.number({kKeys[2], "pH", "pH of the water, for the absorption; left out: 8"}, described.ph,
           from_to(5, 10), unwritten);
  f.number({kKeys[3], "Depth", "Depth below the surface of the water described; left out: 0"},
           described.depth_m, from_to(0, 12000), unwritten);
  return is_given ? std::optional(described) : std::nullopt;
}

// The value is a number, or {from: {temperature_c, salinity_psu, depth_m}}.
void sound_speed_fields(Fields& f, WaterSpec& water,
                        const std::optional<SeaAbsorptionSpec>& described) {
  const Node* given = f.peek("sound_speed_m_s");
  if (described && given == nullptr) {
    water.sound_speed_from = {described->temperature_c, described->salinity_psu,
                              described->depth_m};
  }
  const bool from = f.writing() ? water.sound_speed_from.has_value()
                                : given != nullptr && given->kind == NodeKind::map;
  if (!from) {
    f.number(kSoundSpeedText, water.sound_speed_m_s, from_to(kMinSoundSpeed, kMaxSoundSpeed),
             {.has_default = false});
    return;
  }
  if (described) {
    f.fault("sound_speed_m_s",
            "describes the water a second time, next to water.temperature_c; expected only one of "
            "them");
  }
  if (f.begin(kSoundSpeedText)) {
    f.map({"from", "Sea water",
           "Properties of the water from which the sound speed is computed after Leroy et al. "
           "2008, and from which the absorption follows"},
          water.sound_speed_from, kRequired);
    f.end();
  }
}

// What absorption leaves out is that of the water described elsewhere. A temperature and a salinity
// of its own, in a scenario that describes the water for the sound speed alone, are a description
// of its own.
SeaAbsorptionSpec sea_defaults(Fields& f, const WaterSpec& water,
                               const std::optional<SeaAbsorptionSpec>& described) {
  if (described) return *described;
  const auto& from = water.sound_speed_from;
  FieldReader* reader = f.reader();
  if (!from || reader == nullptr) return {};
  const bool is_own =
      reader->peek("temperature_c") != nullptr && reader->peek("salinity_psu") != nullptr;
  if (is_own) return {};
  SeaAbsorptionSpec same;
  same.temperature_c = from->temperature_c;
  same.salinity_psu = from->salinity_psu;
  same.depth_m = from->depth_m;
  return same;
}

void sea_fields(Fields& f, SeaAbsorptionSpec& model, Rule rule) {
  rule.has_default = false;
  f.number({"temperature_c", "Temperature",
            "Temperature of the water in the model; left out: that of the water described, else "
            "10"},
           model.temperature_c, from_to(-5, 60), rule);
  f.number({"salinity_psu", "Salinity",
            "Salinity of the water in the model; left out: that of the water described, else 35"},
           model.salinity_psu, from_to(0, 100), rule);
  f.number({"ph", "pH",
            "pH of the water in the model; left out: that of the water described, "
            "else 8"},
           model.ph, from_to(5, 10), rule);
  f.number(
      {"depth_m", "Depth", "Depth in the model; left out: that of the water described, else 0"},
      model.depth_m, from_to(0, 12000), rule);
}

void absorption_fields(Fields& f, WaterSpec& water,
                       const std::optional<SeaAbsorptionSpec>& described) {
  constexpr std::string_view kKeys[] = {"fixed_db_m", "model"};
  const auto which =
      f.only_key(kKeys, std::holds_alternative<FixedAbsorptionSpec>(water.absorption) ? 0 : 1,
                 "fixed_db_m (dB/m) or model (francois_garrison, ainslie_mccolm)");
  FixedAbsorptionSpec fixed;
  SeaAbsorptionSpec model = sea_defaults(f, water, described);
  if (f.writing() && which == 0u) fixed = std::get<FixedAbsorptionSpec>(water.absorption);
  if (f.writing() && which == 1u) model = std::get<SeaAbsorptionSpec>(water.absorption);
  const Rule of_model = useless_if(which == 0u, "with fixed_db_m; expected only one of them");
  if (which == 0u) {
    f.number({kKeys[0], "Fixed absorption", "Absorption, in place of a model"}, fixed.db_m,
             from_to(0, 1000), {.has_default = false});
  }
  if (which == 1u) {
    f.choice<AbsorptionModel>({kKeys[1], "Model",
                               "Francois and Garrison 1982, or Ainslie and McColm 1998; in place "
                               "of fixed_db_m"},
                              model.model,
                              {{"francois_garrison", AbsorptionModel::francois_garrison},
                               {"ainslie_mccolm", AbsorptionModel::ainslie_mccolm}},
                              kRequired);
  }
  sea_fields(f, model, of_model);
  if (which == 0u) water.absorption = fixed;
  if (which == 1u) water.absorption = model;
}

void check_rows(FieldReader& reader, const ProfileSpec& profile) {
  if (profile.depth_m.size() != profile.sound_speed_m_s.size()) {
    reader.fault(
        "sound_speed_m_s",
        fmt::format("the number of values is {}, but that of depth_m is {}; expected one for each",
                    profile.sound_speed_m_s.size(), profile.depth_m.size()));
  }
  const Value depths = *child(reader.map(), "depth_m");
  for (std::size_t i = 1; i < profile.depth_m.size(); ++i) {
    if (profile.depth_m[i] > profile.depth_m[i - 1]) continue;
    const Value wrong = item(depths, i);
    add_fault(reader.faults(), wrong.place, wrong.path,
              fmt::format("{} is not below the {} before it; expected increasing depths",
                          profile.depth_m[i], profile.depth_m[i - 1]));
  }
}

}  // namespace

static void fields(Fields& f, ProfileSpec& profile) {
  const bool from_file = f.writing() ? !profile.file.empty() : f.peek("file") != nullptr;
  f.file({"file", "Profile file",
          "CSV file with the columns depth_m and sound_speed_m_s, in place of the two lists; left "
          "out: the two lists"},
         profile.file, {".csv"}, written_if(from_file, {.has_default = false}));
  const ReadWatch watch(f);
  const auto column = [&](const KeyText& key, const NumberRange& range,
                          std::vector<double>& values) {
    const std::string missing = "a list, each item " + in_words(range, "number");
    const ListWords words{missing, "one row or more", 1};
    return f.list(
        key, values, words,
        useless_if(from_file, "with file; expected either the file or both lists", kRequired),
        [&](const std::string& at, double& value) { f.number(at, value, range); });
  };
  const bool depths = column({"depth_m", "Depths", "Depths below the surface, in increasing order"},
                             from_to(kMinDepthM, kMaxDepthM), profile.depth_m);
  const bool speeds = column({"sound_speed_m_s", "Sound speeds",
                              "Sound speed at each of these depths, linear between them and "
                              "constant beyond"},
                             from_to(kMinSoundSpeed, kMaxSoundSpeed), profile.sound_speed_m_s);
  if (depths && speeds && watch.is_well()) check_rows(*f.reader(), profile);
  f.number({"surface_z_m", "Surface height", "Height in the world of depth 0"}, profile.surface_z_m,
           kPosition);
}

void fields(Fields& f, WaterSpec& water) {
  const auto described = description_fields(f);
  sound_speed_fields(f, water, described);
  f.map({"profile", "Sound speed profile",
         "Sound speed as a function of depth, which refracts the rays; left out: sound_speed_m_s "
         "everywhere"},
        water.profile);
  if (f.begin({"absorption", "Absorption",
               "A model of sea water, or one number; left out: francois_garrison with the defaults "
               "of its keys"})) {
    absorption_fields(f, water, described);
    f.end();
  } else if (!f.writing()) {
    water.absorption = sea_defaults(f, water, described);
  }
  if (described) {
    water.density_kg_m3 = water_density_kg_m3(
        {described->temperature_c, described->salinity_psu, described->ph, described->depth_m});
  }
  f.number({"density_kg_m3", "Density",
            "Density of the water, for the echoes of walls and elastic bodies; left out: that of "
            "the water that water.temperature_c and the keys next to it describe, else 1025",
            "kg/m³"},
           water.density_kg_m3, from_to(500, 2000),
           written_if(water.density_kg_m3 != WaterSpec{}.density_kg_m3, {.has_default = false}));
}

static constexpr KeyText kStrengthText = {"strength_db", "Volume scattering strength",
                                          "Backscattering strength of a unit volume of density 1",
                                          "dB re 1/m"};
static constexpr KeyText kExtinctionText = {
    "extinction_db_m", "Extinction",
    "One-way loss through a volume of density 1, in addition to the absorption of the water"};

static void fields(Fields& f, UniformVolumeSpec& uniform) {
  f.number({kStrengthText.key, kStrengthText.title, "Backscattering strength of a unit volume",
            kStrengthText.unit},
           uniform.strength_db, kStrength, kRequired);
  f.numbers({"size_m", "Size", "[x, y, z]; left out: all the water"}, uniform.size_m, kLength);
  if (!f.begin(
          {"patches", "Patches",
           "Random variation of the density, which strength follows, fixed to the volume; left "
           "out: none"},
          written_if(uniform.patches.has_value(), {.has_default = false}))) {
    return;
  }
  if (!uniform.patches) uniform.patches.emplace();
  texture_fields(f, *uniform.patches,
                 {"Distribution of the density, whose mean is 1: gamma or lognormal",
                  "Distance over which the field decorrelates to 1/e", 0.05, 12});
  f.end();
}

static void fields(Fields& f, VdbVolumeSpec& vdb) {
  f.file({"file", "Volume file", "OpenVDB file (.vdb)"}, vdb.file, {".vdb"}, kRequired);
  f.text({"grid", "Grid", "Name of the grid in the file"}, vdb.grid);
  f.number(kStrengthText, vdb.strength_db, kStrength, kRequired);
  f.number(kExtinctionText, vdb.extinction_db_m, kExtinction);
}

static void fields(Fields& f, PlumeSpec& plume) {
  const bool has_radius =
      f.number({"radius_m", "Radius", "Radius at the foot"}, plume.radius_m, kLength, kRequired);
  const bool has_height =
      f.number({"height_m", "Height", "Height of the plume, at most 1000 times radius_m"},
               plume.height_m, kLength, kRequired);
  if (has_radius && has_height && plume.height_m > kMaxPlumeSlimness * plume.radius_m) {
    f.fault("height_m", fmt::format("more than {} times radius_m; expected a lower or wider plume",
                                    kMaxPlumeSlimness));
  }
  f.number({"spread_deg", "Spread", "Angle between the axis and the rim"}, plume.spread_deg,
           from_to(0, 60));
  f.number(kStrengthText, plume.strength_db, kStrength, kRequired);
  f.number(kExtinctionText, plume.extinction_db_m, kExtinction);
}

static void fields(Fields& f, SchoolSpec& school) {
  f.numbers({"size_m", "Size", "Axes [a, b, c] of the ellipsoid"}, school.size_m, kLength,
            kRequired);
  f.integer({"fish", "Fish", "Number of fish"}, school.fish, 1, kMaxFish, kRequired);
  f.number({"target_strength_db", "Target strength", "Target strength of one fish", "dB re 1 m²"},
           school.target_strength_db, from_to(-300, 300), kRequired);
}

void fields(Fields& f, VolumeSpec& volume) {
  f.text({"name", "Name", "Name that no other object, point target or volume has"}, volume.name,
         kRequired);
  f.text({"class", "Class", "Class of the instance"}, volume.class_name);
  const auto kind = f.one_of(
      volume.kind,
      {{{"uniform", "Uniform volume", "A box centered at the origin, or all the water"},
        {"vdb", "OpenVDB volume", "The active voxels of a fog volume of floats, in meters, z up"},
        {"plume", "Bubble plume", "Bubbles that rise along z from a disc at the origin"},
        {"school", "School of fish",
         "Fish at rest, anywhere in an ellipsoid centered at the origin"}}});
  auto* uniform = kind ? std::get_if<UniformVolumeSpec>(&volume.kind) : nullptr;
  const bool is_school = std::holds_alternative<SchoolSpec>(volume.kind);
  double none = 0;
  f.number({kExtinctionText.key, kExtinctionText.title,
            "Of a uniform volume: one-way loss through it, in addition to the absorption of the "
            "water"},
           uniform != nullptr ? uniform->extinction_db_m : none, kExtinction,
           useless_if(kind && uniform == nullptr,
                      is_school ? "on a school, because its fish do not attenuate sound"
                                : "here; expected among the keys of the kind of the volume"));
  const Node* given = f.peek("uniform");
  const bool may_end =
      given != nullptr && (given->kind != NodeKind::map || find(*given, "size_m") != nullptr);
  f.map({"pose", "Pose", "Pose of the volume; not for a uniform volume without size_m"},
        volume.pose,
        useless_if(uniform != nullptr && !uniform->size_m && !may_end,
                   "on a uniform volume without size_m, which is infinite"));
}

namespace {

template <class Refuse>
void refuse_materials(const Value& root, const Scenario& scenario, const Refuse& refuse) {
  if (const auto materials = child(root, "materials")) {
    for (const MaterialSpec& material : scenario.materials) {
      const auto value = child(*materials, material.name);
      if (material.wall) {
        refuse(value ? child(*value, "wall") : value,
               "paths through walls are straight; expected no wall with water.profile");
      }
      if (!std::holds_alternative<KirchhoffSpec>(material.coherent)) continue;
      refuse(value ? child(*value, "coherent") : value,
             "specular echoes are not computed along refracted rays; expected no model kirchhoff "
             "with water.profile");
    }
  }
}

// Elastic objects, and volumes.
template <class Refuse>
void refuse_bodies(const Value& root, const Scenario& scenario, const Refuse& refuse) {
  const auto objects = child(root, "objects");
  for (std::size_t i = 0; objects && i < scenario.objects.size(); ++i) {
    if (!scenario.objects[i].elastic) continue;
    refuse(child(item(*objects, i), "elastic"),
           "elastic bodies are not heard along refracted rays; expected no elastic with "
           "water.profile");
  }
  const auto volumes = child(root, "volumes");
  for (std::size_t i = 0; volumes && i < scenario.volumes.size(); ++i) {
    const VolumeSpec& volume = scenario.volumes[i];
    const auto* uniform = std::get_if<UniformVolumeSpec>(&volume.kind);
    if (uniform != nullptr && uniform->patches) {
      refuse(item(*volumes, i),
             "patches are not found along refracted rays; expected no patches with water.profile");
      continue;
    }
    const bool open = uniform != nullptr && !uniform->size_m;
    if (open || std::holds_alternative<SchoolSpec>(volume.kind)) continue;
    refuse(item(*volumes, i),
           "bounded volumes are not computed along refracted rays; expected uniform volumes "
           "without size_m, or schools, with water.profile");
  }
}

}  // namespace

void check_profile_conflicts(Faults& faults, const Value& root, const Scenario& scenario) {
  if (!scenario.water.profile) return;
  const auto refuse = [&](std::optional<Value> value, const std::string& text) {
    const Value at = value ? *value : root;
    add_fault(faults, at.place, at.path, text);
  };
  if (scenario.multipath) {
    refuse(child(root, "multipath"),
           "multipath is not computed along refracted rays; expected multipath or water.profile, "
           "but not both");
  }
  if (scenario.bounces > 0) {
    refuse(child(root, "bounces"),
           "paths over several surfaces are straight; expected bounces: 0, or no water.profile");
  }
  if (scenario.motion_within_ping) {
    refuse(child(root, "motion_within_ping"),
           "motion within a ping is not computed along refracted rays; expected motion_within_ping "
           "or water.profile, but not both");
  }
  if (scenario.scattering.speckle == SpeckleMode::surface) {
    const auto scattering = child(root, "scattering");
    refuse(scattering ? child(*scattering, "speckle") : scattering,
           "scatterers fixed on surfaces are not found along refracted rays; expected per_ping or "
           "per_ray with water.profile");
  }
  refuse_materials(root, scenario, refuse);
  refuse_bodies(root, scenario, refuse);
}

}  // namespace ensonify
