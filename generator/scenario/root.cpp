// The keys of the top level of a scenario and of its small sections: scattering, multipath, noise,
// synthesis, splits and dataset.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string_view>

#include "formats/csv.h"
#include "scenario/rig.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr int kMaxSequences = 1'000'000;

void head_fields(Fields& f, Scenario& scenario) {
  int version = 1;
  f.integer({"ensonify", "Format version", "Version of the scenario format"}, version, 1, 1,
            kRequired);
  f.text({"name", "Name", "Name of the data set; left out: the file's name without its ending"},
         scenario.name, {.has_default = false});
  f.seed({"seed", "Seed", "Seed of everything that is random"}, scenario.seed);
  f.seed({"speckle_seed", "Speckle seed",
          "Samples the amplitudes of all diffuse scatterers and of the cells of volumes again, and "
          "nothing else; left out: they follow from the seed alone"},
         scenario.speckle_seed);
  auto sequences = static_cast<int>(scenario.sequences);
  f.integer({"sequences", "Sequences",
             "Number of worlds; sampled values, speckle, noise and split differ between them"},
            sequences, 1, kMaxSequences);
  scenario.sequences = static_cast<std::uint32_t>(sequences);
}

// Arbitrary values by name, which replace their uses before the other keys are read.
void variable_fields(Fields& f) {
  std::vector<std::string> names;
  if (f.begin({"variables", "Variables",
               "Values and distributions by names that are free to choose, each sampled once for a "
               "sequence; other keys use them as $name, $name.key of a map, or in an expression, "
               "\"= 0.5 * name + 1\"; left out: none"},
              NamesBranch{names, ""}, written_if(false))) {
    f.end();
  }
}

void materials_fields(Fields& f, std::vector<MaterialSpec>& materials) {
  std::vector<std::string> names;
  for (const MaterialSpec& material : materials) names.push_back(material.name);
  const std::string_view what =
      "not a map; expected a map of names, such as {steel: {reflectivity: 1e-2}}";
  if (!f.begin({"materials", "Materials",
                "Materials by names that are free to choose: how surfaces scatter; left out: none"},
               NamesBranch{names, what}, {.in_lines = true})) {
    return;
  }
  materials.resize(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    f.map(names[i], materials[i]);
    materials[i].name = std::move(names[i]);
  }
  f.end();
}

bool is_day(std::string_view text) {
  const auto part = [&](std::size_t start, std::size_t count) {
    return parse_number<int>(text.substr(start, count)).value_or(-1);
  };
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  const std::chrono::year_month_day day{std::chrono::year(part(0, 4)),
                                        std::chrono::month(static_cast<unsigned>(part(5, 2))),
                                        std::chrono::day(static_cast<unsigned>(part(8, 2)))};
  return part(0, 4) > 0 && day.ok();
}

// From here on, objects may refer to these materials.
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
  const bool has_noise = by_level || scenario.noise_snr_db;
  if (!f.begin({"noise", "Noise", "Level of the receiver noise; left out: no noise"},
               written_if(has_noise, {.has_default = has_noise}))) {
    return;
  }
  const auto which = f.only_key(kKeys, by_level ? 0 : 1,
                                "either spectrum_level_db (dB re 1 uPa^2/Hz) or snr_db (dB)");
  if (which == 0u) {
    f.number({kKeys[0], "Spectrum level", "NL, in place of snr_db", "dB re 1 µPa²/Hz"},
             scenario.noise_spectrum_level_db, from_to(-300, 300));
  }
  if (which == 1u) {
    f.number({kKeys[1], "Signal-to-noise ratio",
              "Mean expected power of ping 0 over the samples that hold an echo, relative to the "
              "noise power; in place of spectrum_level_db"},
             scenario.noise_snr_db, from_to(-100, 200));
  }
  const bool is_array = scenario.sonar.array.has_value();
  f.boolean({"correlated", "Correlated",
             "Whether the noise of neighboring beams is correlated as their patterns overlap; "
             "false: it is independent"},
            scenario.noise_correlated,
            useless_if(is_array,
                       "with sonar.receiver.mode: array, whose beams share the noise of "
                       "the elements; expected no key",
                       written_if(!is_array && scenario.noise_correlated)));
  f.end();
}

}  // namespace

static void fields(Fields& f, ScatteringSpec& scattering) {
  constexpr auto kExponent = Lambert::parameters()[0];
  f.number(
      {"lambert_exponent", "Lambert exponent",
       "n of σ² = μ cosⁿ(α) dA, for materials without an exponent of their own; 1 is Lambert's "
       "law"},
      scattering.lambert_exponent, from_to(kExponent.least, kExponent.most));
  f.choice<Normalization>(
      {"normalization", "Normalization",
       "calibrated: levels satisfy the sonar equation; mean_square: Eq. 16 of Choi et al. 2021"},
      scattering.normalization,
      {{"calibrated", Normalization::calibrated}, {"mean_square", Normalization::mean_square}});
  f.choice<SpeckleMode>(
      {"speckle", "Speckle",
       "per_ping: each ping has a new random pattern; per_ray: one pattern, fixed "
       "in the sonar's frame; surface: scatterers are fixed on the surfaces"},
      scattering.speckle, words_to(SpeckleMode::surface));
}

static void fields(Fields& f, FlatSurface& surface) {
  f.number({"z_m", "Height", "Height in the world"}, surface.z_m, kPosition, kRequired);
  f.number({"reflection", "Reflection coefficient",
            "Amplitude reflection coefficient; a negative one inverts the phase"},
           surface.reflection, from_to(-1, 1), kRequired);
  f.number({"roughness_rms_m", "Roughness", "Rms height, which reduces the reflection"},
           surface.roughness_rms_m, from_to(0, 1));
}

static void fields(Fields& f, Multipath& multipath) {
  const ReadWatch watch(f);
  f.map({"surface", "Sea surface",
         "Infinite horizontal specular reflector that sound stays below; left out: none"},
        multipath.surface);
  f.map({"bottom", "Bottom",
         "Infinite horizontal specular reflector below the surface; left out: none"},
        multipath.bottom);
  f.boolean({"objects", "Objects",
             "Whether planes and box faces with a kirchhoff material are specular reflectors"},
            multipath.objects);
  f.integer({"bounces", "Bounces",
             "Largest number of reflections of an echo, outbound and inbound together"},
            multipath.bounces, 1, kMaxBounces);
  if (!watch.is_well()) return;
  const auto& [surface, bottom, objects, bounces] = multipath;
  if (!surface && !bottom && !objects) {
    f.fault("", "there is no specular reflector; expected surface, bottom or objects: true");
  }
  if (surface && bottom && !(bottom->z_m < surface->z_m)) {
    const Value below = child_or_empty(f.reader()->map(), "bottom");
    add_fault(f.reader()->faults(), below.place, path_of(below, "z_m"),
              "the bottom is not below the surface; expected a z_m less than surface.z_m");
  }
}

static void fields(Fields& f, SplitsSpec& splits) {
  const NumberRange fraction = from_to(0, 1e6);
  const ReadWatch watch(f);
  if (!f.writing()) splits = {0, 0, 0};
  f.number({"train", "Training", "Share of the sequences in train"}, splits.train, fraction);
  f.number({"val", "Validation", "Share of the sequences in val"}, splits.val, fraction);
  f.number({"test", "Test", "Share of the sequences in test"}, splits.test, fraction);
  if (!watch.is_well()) return;
  if (splits.train + splits.val + splits.test > 0) return;
  f.fault("", "the fractions train, val and test are all zero; expected a sum above zero");
}

static void fields(Fields& f, DatasetSpec& dataset) {
  const auto stated = [](const std::string& text) {
    return written_if(!text.empty(), {.has_default = false});
  };
  f.text(
      {"license", "License",
       "SPDX identifier, such as CC-BY-4.0, or the address of the license; left out: not stated"},
      dataset.license, stated(dataset.license));
  f.text(
      {"creator", "Creator", "Person or organization that made the data set; left out: not stated"},
      dataset.creator, stated(dataset.creator));
  f.long_text({"citation", "Citation",
               "How to cite the data set, as text or BibTeX on one line; left "
               "out: not stated"},
              dataset.citation, kMaxFileNameBytes, stated(dataset.citation));
  f.long_text({"url", "Address", "Where the data set is published; left out: not stated"},
              dataset.url, kMaxFileNameBytes, stated(dataset.url));
  const ReadWatch watch(f);
  f.text(
      {"published", "Publication date", "Day of publication, \"YYYY-MM-DD\"; left out: not stated"},
      dataset.published, stated(dataset.published));
  if (watch.is_well() && !dataset.published.empty() && !is_day(dataset.published)) {
    f.fault("published",
            fmt::format("\"{}\" is not a day; expected YYYY-MM-DD", dataset.published));
  }
}

static constexpr Rule kLines{.in_lines = true};

static void instrument_fields(Fields& f, Scenario& scenario) {
  const bool has_rig =
      f.writing() ? !scenario.rig.empty() : f.reader() != nullptr && f.peek("rig") != nullptr;
  f.map({"sonar", "Sonar",
         "The instrument: a preset, keys that override it, or all keys without a preset"},
        scenario.sonar,
        {.need = has_rig ? Need::optional : Need::required,
         .unless = "rig",
         .written = !has_rig,
         .in_lines = true});
  rig_fields(f, scenario);
  f.map({"camera", "Camera",
         "A camera on the same body, with an image at each ping of the same world; left out: none"},
        scenario.camera, written_if(!has_rig, kLines));
  f.map({"water", "Water", "Sound speed and absorption"}, scenario.water, kLines);
  f.map({"scattering", "Scattering", "Defaults of the surfaces, and the speckle"},
        scenario.scattering);
}

static void world_fields(Fields& f, Scenario& scenario) {
  f.maps(
      {"objects", "Objects",
       "Surfaces with a material, at rest or moving; each is one instance in the labels, and ids "
       "follow the order of the list; left out: none"},
      scenario.objects, kLines);
  f.maps({"point_targets", "Point targets",
          "Ideal point reflectors, labeled as instances after the objects; left out: none"},
         scenario.point_targets, kLines);
  f.maps({"volumes", "Volumes",
          "Scattering in the water itself, each exactly one of uniform, vdb, plume and school, "
          "labeled as instances after the point targets; left out: none"},
         scenario.volumes, kLines);
  class_fields(f, scenario.classes);
  f.map(
      {"multipath", "Multipath",
       "Echoes via specular reflectors, in addition to the direct echoes; left out: direct echoes "
       "only"},
      scenario.multipath);
  f.integer({"bounces", "Bounces",
             "Largest number of surfaces on a path beyond the first one: reflections off smooth "
             "surfaces and scattering between any surfaces; not with multipath or water.profile"},
            scenario.bounces, 0, kMostBounces, written_if(scenario.bounces > 0));
  if (scenario.bounces > 0 && scenario.multipath) {
    f.fault("bounces",
            "cannot be combined with multipath, whose paths it has as well; expected only "
            "one of them");
  }
  if (has_walls(scenario) && scenario.multipath) {
    f.fault("multipath",
            "cannot be combined with materials that have a wall; expected bounces in "
            "place of multipath");
  }
}

static void motion_fields(Fields& f, Scenario& scenario) {
  if (f.begin({"trajectory", "Trajectory",
               "Where the body is at each time, and when the sonar pings; left out: at rest at the "
               "origin"},
              kLines)) {
    sonar_trajectory_fields(f, scenario.trajectory);
    f.end();
  } else if (!f.writing()) {
    scenario.trajectory.path = std::vector<TimedPoseSpec>(1);
    scenario.trajectory.pings = 1;
  }
  f.boolean({"motion_within_ping", "Motion within the ping",
             "Whether sonar and objects move while the sound travels, which changes arrivals, "
             "delays and Doppler"},
            scenario.motion_within_ping, written_if(scenario.motion_within_ping));
  f.map(
      {"navigation", "Navigation", "Navigation sensors of the body; left out: none are simulated"},
      scenario.navigation, written_if(scenario.rig.empty(), kLines));
}

// Masks accompany images of electronics that leave marks in them.
static void select_artifacts(Scenario& scenario) {
  if (!scenario.sonar.electronics) return;
  const bool marks = leaves_marks(scenario.sonar.electronics->front_end);
  OutputSelection& selection = scenario.output.selection;
  selection.artifact = marks && (selection.polar || selection.cartesian);
}

static void product_fields(Fields& f, Scenario& scenario) {
  if (f.begin({"synthesis", "Synthesis", "Accuracy of the time series"})) {
    f.number(
        {"tolerance", "Tolerance",
         "Relative error (L2) of the time series over the record, compared with the direct sum "
         "in double precision"},
        scenario.synthesis_tolerance, from_to(1e-7, 1e-3));
    f.end();
  }
  if (f.begin({"output", "Output", "Which files each ping has"})) {
    output_fields(f, scenario);
    f.end();
  } else if (!f.writing()) {
    scenario.output.selection.multipath = has_more_paths(scenario);
    scenario.output.selection.camera_geometry = scenario.output.selection.camera_color =
        has_camera(scenario);
  }
  f.map({"splits", "Splits",
         "Relative shares of the sequences, with a sum above zero; left out: all in train"},
        scenario.splits);
  const DatasetSpec& dataset = scenario.dataset;
  const bool is_stated =
      !(dataset.license + dataset.creator + dataset.citation + dataset.url + dataset.published)
           .empty();
  if (f.begin({"dataset", "Data set",
               "What catalogs of data sets ask for, in croissant.json and README.md; no effect on "
               "other files; left out: not stated"},
              written_if(is_stated, {.has_default = false}))) {
    fields(f, scenario.dataset);
    f.end();
  }
}

// What a sonar excludes in other sections, and the reverse.
static void check_sonar(Faults& faults, const Value& root, const Scenario& scenario) {
  check_array(faults, root, scenario);
  check_transmit(faults, root, scenario);
  check_ping_size(faults, root, scenario);
  check_burst_length(faults, root, scenario);
  check_detector(faults, root, scenario);
  check_profile_conflicts(faults, root, scenario);
}

void fields(Fields& f, Scenario& scenario) {
  head_fields(f, scenario);
  variable_fields(f);
  instrument_fields(f, scenario);
  materials_fields(f, scenario.materials);
  know_materials(f, scenario.materials);
  check_growth(f, scenario.materials);
  world_fields(f, scenario);
  motion_fields(f, scenario);
  noise_fields(f, scenario);
  product_fields(f, scenario);
  select_artifacts(scenario);
  if (!f.writing()) select_outputs(scenario);
  const FieldReader* reader = f.reader();
  if (reader == nullptr) return;
  check_places(reader->faults(), reader->map());
  check_parents(reader->faults(), reader->map());
  check_instances(reader->faults(), reader->map());
  check_elastic(reader->faults(), reader->map(), scenario);
  if (scenario.rig.empty()) return check_sonar(reader->faults(), reader->map(), scenario);
  const auto chosen = chosen_index(scenario);
  if (!chosen || !is_sonar(scenario)) return;
  const Node tree = chosen_sonar_tree(*reader->map().node, *chosen);
  const std::size_t before = reader->faults().list.size();
  check_sonar(reader->faults(), {&tree, reader->map().place, ""}, scenario);
  for (std::size_t i = before; i < reader->faults().list.size(); ++i) {
    std::string& path = reader->faults().list[i].path;
    path = in_rig(path, *chosen);
  }
}

bool varies_by_sequence(const Scenario& scenario) {
  if (scenario.sonar.recorder && scenario.sonar.recorder->dropped > 0) return true;
  const auto is_drawn = [](const ObjectSpec& object) {
    const auto* field = std::get_if<HeightfieldSpec>(&object.shape);
    return (field != nullptr && is_random(*field)) ||
           (object.trajectory && object.trajectory->wave_motion);
  };
  const auto is_drawn_volume = [](const VolumeSpec& volume) {
    const auto* uniform = std::get_if<UniformVolumeSpec>(&volume.kind);
    return (uniform != nullptr && uniform->patches) ||
           std::holds_alternative<PlumeSpec>(volume.kind) ||
           std::holds_alternative<SchoolSpec>(volume.kind);
  };
  const auto is_uneven = [](const MaterialSpec& material) {
    return material.texture || material.growth;
  };
  return scenario.has_draws || scenario.trajectory.wave_motion ||
         std::any_of(scenario.materials.begin(), scenario.materials.end(), is_uneven) ||
         std::any_of(scenario.volumes.begin(), scenario.volumes.end(), is_drawn_volume) ||
         std::any_of(scenario.objects.begin(), scenario.objects.end(), is_drawn);
}

}  // namespace ensonify
