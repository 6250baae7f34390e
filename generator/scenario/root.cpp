// The top level of a scenario and its small sections: scattering, multipath, noise, synthesis,
// splits.
#include <algorithm>

#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr int kMaxSequences = 1'000'000;

void head_fields(Fields& f, Scenario& scenario) {
  int version = 1;
  f.integer("ensonify", version, 1, 1, kRequired);
  f.text("name", scenario.name);
  f.seed("seed", scenario.seed);
  auto sequences = static_cast<int>(scenario.sequences);
  f.integer("sequences", sequences, 1, kMaxSequences);
  scenario.sequences = static_cast<std::uint32_t>(sequences);
}

void materials_fields(Fields& f, std::vector<MaterialSpec>& materials) {
  std::vector<std::string> names;
  for (const MaterialSpec& material : materials) names.push_back(material.name);
  const std::string_view what =
      "no map, accepted is a map of names, as in {steel: {reflectivity: 1e-2}}";
  if (!f.begin("materials", NamesBranch{names, what}, {.in_lines = true})) return;
  materials.resize(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    f.map(names[i], materials[i]);
    materials[i].name = std::move(names[i]);
  }
  f.end();
}

// What objects may refer to from here on.
void know_materials(Fields& f, const std::vector<MaterialSpec>& materials) {
  FieldReader* reader = f.reader();
  if (reader == nullptr) return;
  for (const MaterialSpec& material : materials) {
    reader->materials.set.insert(material.name);
    reader->materials.list.push_back(material.name);
  }
}

void noise_fields(Fields& f, Scenario& scenario) {
  constexpr std::string_view kKeys[] = {"spectrum_level_db", "snr_db"};
  const bool by_level = scenario.noise_spectrum_level_db.has_value();
  if (!f.begin("noise", written_if(by_level || scenario.noise_snr_db))) return;
  const auto which = f.only_key(
      kKeys, by_level ? 0 : 1, "either alone: spectrum_level_db (dB re 1 uPa^2/Hz) or snr_db (dB)");
  if (which == 0u) f.number(kKeys[0], scenario.noise_spectrum_level_db, from_to(-300, 300));
  if (which == 1u) f.number(kKeys[1], scenario.noise_snr_db, from_to(-100, 200));
  f.end();
}

}  // namespace

static void fields(Fields& f, ScatteringSpec& scattering) {
  f.number("lambert_exponent", scattering.lambert_exponent, kLambertExponent);
  f.choice<Normalization>(
      "normalization", scattering.normalization,
      {{"calibrated", Normalization::calibrated}, {"mean_square", Normalization::mean_square}});
  f.choice<SpeckleMode>("speckle", scattering.speckle, words_to(SpeckleMode::surface));
}

static void fields(Fields& f, FlatSurface& surface) {
  f.number("z_m", surface.z_m, kPosition, kRequired);
  f.number("reflection", surface.reflection, from_to(-1, 1), kRequired);
  f.number("roughness_rms_m", surface.roughness_rms_m, from_to(0, 1));
}

static void fields(Fields& f, Multipath& multipath) {
  const ReadWatch watch(f);
  f.map("surface", multipath.surface);
  f.map("bottom", multipath.bottom);
  f.boolean("objects", multipath.objects);
  f.integer("bounces", multipath.bounces, 1, kMaxBounces);
  if (!watch.is_well()) return;
  const auto& [surface, bottom, objects, bounces] = multipath;
  if (!surface && !bottom && !objects) {
    f.fault("", "there is nothing to bounce off, accepted is surface, bottom or objects: true");
  }
  if (surface && bottom && !(bottom->z_m < surface->z_m)) {
    const Value below = child_or_empty(f.reader()->map(), "bottom");
    add_fault(f.reader()->faults(), below.place, path_of(below, "z_m"),
              "not below the surface, accepted is a bottom whose z_m is less than surface.z_m");
  }
}

static void fields(Fields& f, SplitsSpec& splits) {
  const NumberRange fraction = from_to(0, 1e6);
  const ReadWatch watch(f);
  if (!f.writing()) splits = {0, 0, 0};
  f.number("train", splits.train, fraction);
  f.number("val", splits.val, fraction);
  f.number("test", splits.test, fraction);
  if (!watch.is_well()) return;
  if (splits.train + splits.val + splits.test > 0) return;
  f.fault("", "the fractions train, val and test are all zero, accepted is a sum above zero");
}

void fields(Fields& f, Scenario& scenario) {
  constexpr Rule kLines{.in_lines = true};
  constexpr Rule kRequiredLines{.need = Need::required, .in_lines = true};
  head_fields(f, scenario);
  f.map("sonar", scenario.sonar, kRequiredLines);
  f.map("water", scenario.water, kLines);
  f.map("scattering", scenario.scattering);
  materials_fields(f, scenario.materials);
  know_materials(f, scenario.materials);
  f.maps("objects", scenario.objects, kLines);
  f.maps("point_targets", scenario.point_targets, kLines);
  f.maps("volumes", scenario.volumes, kLines);
  f.map("multipath", scenario.multipath);
  if (f.begin("trajectory", kRequiredLines)) {
    sonar_trajectory_fields(f, scenario.trajectory);
    f.end();
  }
  f.boolean("motion_within_ping", scenario.motion_within_ping,
            written_if(scenario.motion_within_ping));
  noise_fields(f, scenario);
  if (f.begin("synthesis")) {
    f.number("tolerance", scenario.synthesis_tolerance, from_to(1e-7, 1e-3));
    f.end();
  }
  if (f.begin("output")) {
    output_fields(f, scenario);
    f.end();
  } else if (!f.writing()) {
    scenario.output.selection.multipath = scenario.multipath.has_value();
  }
  f.map("splits", scenario.splits);
  const FieldReader* reader = f.reader();
  if (reader == nullptr) return;
  check_places(reader->faults(), reader->map());
  check_instances(reader->faults(), reader->map());
  check_array(reader->faults(), reader->map(), scenario);
  check_ping_size(reader->faults(), reader->map(), scenario);
  check_burst_length(reader->faults(), reader->map(), scenario);
  check_profile_conflicts(reader->faults(), reader->map(), scenario);
}

bool varies_by_sequence(const Scenario& scenario) {
  const auto is_drawn = [](const ObjectSpec& object) {
    const auto* field = std::get_if<HeightfieldSpec>(&object.shape);
    return (field != nullptr && field->file.empty()) ||
           (object.trajectory && object.trajectory->jitter);
  };
  const auto is_drawn_volume = [](const VolumeSpec& volume) {
    return std::holds_alternative<PlumeSpec>(volume.kind) ||
           std::holds_alternative<SchoolSpec>(volume.kind);
  };
  return scenario.has_draws || scenario.trajectory.jitter ||
         std::any_of(scenario.volumes.begin(), scenario.volumes.end(), is_drawn_volume) ||
         std::any_of(scenario.objects.begin(), scenario.objects.end(), is_drawn);
}

}  // namespace ensonify
