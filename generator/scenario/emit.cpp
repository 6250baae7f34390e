#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenario/drawn_sections.h"
#include "scenario/emit.h"

namespace ensonify {
namespace {

std::string pulse_text(const PulseSpec& pulse, const NameFile& name_file) {
  switch (pulse.shape) {
    case PulseShape::gaussian:
    case PulseShape::flat:
      break;
    case PulseShape::lfm:
      return fmt::format("{{lfm: {{duration_s: {}, taper: {}}}}}", number(pulse.duration_s),
                         number(pulse.taper));
    case PulseShape::cw:
      return fmt::format("{{cw: {{duration_s: {}}}}}", number(pulse.duration_s));
    case PulseShape::table:
      return fmt::format("{{table: {{file: {}}}}}", quoted_if_needed(name_file(pulse.file)));
  }
  return name_of(pulse.shape);
}

std::string shading_text(const BeamShading& shading) {
  switch (shading.kind) {
    case Shading::uniform:
    case Shading::hann:
      break;
    case Shading::taylor:
      return fmt::format("{{taylor: {{side_lobe_db: {}, nbar: {}}}}}", number(shading.side_lobe_db),
                         shading.nbar);
    case Shading::chebyshev:
      return fmt::format("{{chebyshev: {{side_lobe_db: {}}}}}", number(shading.side_lobe_db));
  }
  return name_of(shading.kind);
}

std::string beams_text(const SonarSpec& sonar) {
  std::string text = fmt::format("{{count: {}, fov_deg: {}, width_deg: {}, shading: {}",
                                 sonar.beam_count, number(sonar.beam_fov_deg),
                                 number(sonar.beam_width_deg), shading_text(sonar.shading));
  if (sonar.transmit_width_deg) {
    text += ", transmit_width_deg: " + number(*sonar.transmit_width_deg);
  }
  return text + "}";
}

std::string array_text(const ArraySpec& array) {
  std::string text = "mode: array";
  if (array.elements) text += fmt::format(", elements: {}", *array.elements);
  if (array.spacing_m) text += ", spacing_m: " + number(*array.spacing_m);
  if (array.shading) text += ", shading: " + shading_text(*array.shading);
  return text + fmt::format(
                    ", element_width_m: {}, focus: {}, steering: {}, gain_error_db: {}, "
                    "phase_error_deg: {}, dead: [{}]",
                    number(array.element_width_m), name_of(array.focus), name_of(array.steering),
                    number(array.gain_error_db), number(array.phase_error_deg),
                    fmt::join(array.dead, ", "));
}

// Empty: what is left out says as much.
std::string receiver_text(const SonarSpec& sonar) {
  std::string text = sonar.array ? array_text(*sonar.array) : "";
  if (!sonar.adc) return text;
  return text + fmt::format("{}adc: {{bits: {}, full_scale_db: {}}}", text.empty() ? "" : ", ",
                            sonar.adc->bits, number(sonar.adc->full_scale_db));
}

std::string sonar_text(const SonarSpec& sonar, const NameFile& name_file) {
  std::string text = "sonar:\n";
  const auto line = [&](std::string_view key, const std::string& value) {
    text += fmt::format("  {}: {}\n", key, value);
  };
  line("frequency_hz", number(sonar.frequency_hz));
  line("bandwidth_hz", number(sonar.bandwidth_hz));
  line("pulse", pulse_text(sonar.pulse, name_file));
  line("window", name_of(sonar.window));
  line("source_level_db", number(sonar.source_level_db));
  line("range_min_m", number(sonar.range_min_m));
  line("range_max_m", number(sonar.range_max_m));
  line("beams", beams_text(sonar));
  line("elevation", fmt::format("{{width_deg: {}, fan_deg: {}}}", number(sonar.elevation_width_deg),
                                number(sonar.elevation_fan_deg)));
  line("rays", fmt::format("{{elevation: {}, azimuth: {}, per_cell: {}}}", sonar.rays_elevation,
                           sonar.rays_azimuth, sonar.rays_per_cell));
  if (const std::string receiver = receiver_text(sonar); !receiver.empty()) {
    line("receiver", "{" + receiver + "}");
  }
  line("mount", fmt::format("{{{}}}", pose_keys(sonar.mount)));
  return text;
}

std::string list_text(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + number(value);
  return "[" + text + "]";
}

std::string profile_text(const ProfileSpec& profile, const NameFile& name_file) {
  const std::string rows =
      profile.file.empty()
          ? fmt::format("depth_m: {}, sound_speed_m_s: {}", list_text(profile.depth_m),
                        list_text(profile.sound_speed_m_s))
          : "file: " + quoted_if_needed(name_file(profile.file));
  return fmt::format("  profile: {{{}, surface_z_m: {}}}\n", rows, number(profile.surface_z_m));
}

std::string water_text(const WaterSpec& water, const NameFile& name_file) {
  std::string absorption;
  if (const auto* fixed = std::get_if<FixedAbsorptionSpec>(&water.absorption)) {
    absorption = "fixed_db_m: " + number(fixed->db_m);
  } else {
    const auto& model = std::get<SeaAbsorptionSpec>(water.absorption);
    absorption = fmt::format(
        "model: {}, temperature_c: {}, salinity_psu: {}, ph: {}, depth_m: {}",
        model.model == AbsorptionModel::francois_garrison ? "francois_garrison" : "ainslie_mccolm",
        number(model.temperature_c), number(model.salinity_psu), number(model.ph),
        number(model.depth_m));
  }
  std::string speed = number(water.sound_speed_m_s);
  if (const auto& from = water.sound_speed_from) {
    speed =
        fmt::format("{{from: {{temperature_c: {}, salinity_psu: {}, depth_m: {}}}}}",
                    number(from->temperature_c), number(from->salinity_psu), number(from->depth_m));
  }
  const std::string profile = water.profile ? profile_text(*water.profile, name_file) : "";
  return fmt::format("water:\n  sound_speed_m_s: {}\n{}  absorption: {{{}}}\n", speed, profile,
                     absorption);
}

std::string scattering_text(const ScatteringSpec& scattering) {
  return fmt::format(
      "scattering: {{lambert_exponent: {}, normalization: {}, speckle: {}}}\n",
      number(scattering.lambert_exponent),
      scattering.normalization == Normalization::calibrated ? "calibrated" : "mean_square",
      name_of(scattering.speckle));
}

std::string material_keys(const MaterialSpec& material, const NameFile& name_file) {
  const std::string reflectivity = "reflectivity: " + number(material.reflectivity);
  std::string text;
  if (const auto* table = std::get_if<BackscatterTableSpec>(&material.law)) {
    text = fmt::format("law: {{table: {{file: {}}}}}", quoted_if_needed(name_file(table->file)));
  } else if (std::holds_alternative<LommelSeeligerSpec>(material.law)) {
    text = reflectivity + ", law: lommel_seeliger";
  } else if (const auto exponent = std::get<LambertSpec>(material.law).exponent) {
    text = fmt::format("{}, law: {{lambert: {{exponent: {}}}}}", reflectivity, number(*exponent));
  } else {
    text = reflectivity + ", law: lambert";
  }
  if (const auto* rician = std::get_if<RicianSpec>(&material.coherent)) {
    text += fmt::format(", coherent: {{model: rician, k: {}}}", number(rician->k));
  } else if (const auto* kirchhoff = std::get_if<KirchhoffSpec>(&material.coherent)) {
    text += fmt::format(", coherent: {{model: kirchhoff, reflection: {}, roughness_rms_m: {}}}",
                        number(kirchhoff->reflection), number(kirchhoff->roughness_rms_m));
  }
  return text;
}

std::string materials_text(const std::vector<MaterialSpec>& materials, const NameFile& name_file) {
  if (materials.empty()) return "materials: {}\n";
  std::string text = "materials:\n";
  for (const MaterialSpec& material : materials) {
    text += fmt::format("  {}: {{{}}}\n", quoted_if_needed(material.name),
                        material_keys(material, name_file));
  }
  return text;
}

std::string objects_text(const std::vector<ObjectSpec>& objects, const NameFile& name_file) {
  if (objects.empty()) return "objects: []\n";
  std::string text = "objects:\n";
  for (const ObjectSpec& object : objects) {
    std::string where = fmt::format("pose: {{{}}}", pose_keys(object.pose));
    if (object.place) where = fmt::format("place: {{{}}}", place_keys(*object.place));
    if (object.trajectory) where = object_trajectory_text(*object.trajectory, name_file);
    text +=
        fmt::format("  - {{name: {}, class: {}, material: {}, shape: {{{}}}, {}}}\n",
                    quoted_if_needed(object.name), quoted_if_needed(object.class_name),
                    quoted_if_needed(object.material), shape_text(object.shape, name_file), where);
  }
  return text;
}

std::string point_targets_text(const std::vector<PointTargetSpec>& targets) {
  if (targets.empty()) return "point_targets: []\n";
  std::string text = "point_targets:\n";
  for (const PointTargetSpec& target : targets) {
    text += fmt::format("  - {{name: {}, class: {}, target_strength_db: {}, position_m: {}}}\n",
                        quoted_if_needed(target.name), quoted_if_needed(target.class_name),
                        number(target.target_strength_db), numbers(target.position_m));
  }
  return text;
}

std::string multipath_text(const Scenario& scenario) {
  if (!scenario.multipath) return "";
  const auto& [surface, bottom, objects, bounces] = *scenario.multipath;
  std::string text = "multipath: {";
  const auto add = [&](const char* key, const std::optional<FlatSurface>& flat) {
    if (!flat) return;
    text += fmt::format("{}: {{z_m: {}, reflection: {}, roughness_rms_m: {}}}, ", key,
                        number(flat->z_m), number(flat->reflection), number(flat->roughness_rms_m));
  };
  add("surface", surface);
  add("bottom", bottom);
  return text + fmt::format("objects: {}, bounces: {}}}\n", objects, bounces);
}

std::string noise_text(const Scenario& scenario) {
  if (const auto level = scenario.noise_spectrum_level_db) {
    return fmt::format("noise: {{spectrum_level_db: {}}}\n", number(*level));
  }
  if (const auto ratio = scenario.noise_snr_db) {
    return fmt::format("noise: {{snr_db: {}}}\n", number(*ratio));
  }
  return "";
}

const char* timeseries_word(const OutputSelection& selection) {
  if (selection.timeseries) return selection.timeseries_exr ? "both" : "npy";
  return selection.timeseries_exr ? "exr" : "none";
}

std::string png_text(const OutputSpec& output) {
  if (!output.selection.png) return "false";
  if (!output.png_db && output.png == GreySettings{}) return "true";
  std::string text =
      fmt::format("{{scale: {}", output.png.scale == GreyScale::db ? "db" : "amplitude");
  if (output.png_db) text += fmt::format(", db: {}", numbers(*output.png_db));
  return text + fmt::format(", tvg: {{spreading: {}, absorption: {}}}, gain_db: {}}}",
                            number(output.png.spreading), output.png.absorption,
                            number(output.png.gain_db));
}

std::string layers_text(const OutputSpec& output) {
  if (!output.selection.layers) return "false";
  if (!output.layer_targets) return "true";
  std::string names;
  for (const std::string& name : *output.layer_targets) {
    names += (names.empty() ? "" : ", ") + quoted_if_needed(name);
  }
  return fmt::format("{{targets: [{}]}}", names);
}

// Left out where there are none, as ever before.
std::string statistics_text(const OutputSelection& output) {
  if (!output.statistics) return "";
  return fmt::format(", statistics: true, pings: {}", output.pings);
}

std::string output_text(const Scenario& scenario) {
  const OutputSpec& output = scenario.output;
  std::string cartesian = "false";
  if (output.selection.cartesian) {
    cartesian = fmt::format("{{height_px: {}}}", output.cartesian_height_px);
  }
  std::string multipath;
  if (scenario.multipath) multipath = fmt::format("multipath: {}, ", output.selection.multipath);
  std::string sdf;
  if (output.sdf) {
    sdf = fmt::format(", sdf: {{voxel_m: {}, band_voxels: {}}}", number(output.sdf->voxel_m),
                      output.sdf->band_voxels);
  }
  return fmt::format(
      "output: {{timeseries: {}, polar: {}, cartesian: {}, png: {}, shadow: {}, amodal: {}, "
      "{}polygons: {}, scatterers: {}, points: {}, layers: {}, pack: {}{}{}{}}}\n",
      timeseries_word(output.selection), output.selection.polar, cartesian, png_text(output),
      output.selection.shadow, output.selection.amodal, multipath, output.selection.polygons,
      output.selection.scatterers, output.selection.points, layers_text(output),
      output.selection.packed ? "sequence" : "ping",
      output.selection.channels ? ", channels: true" : "", sdf, statistics_text(output.selection));
}

}  // namespace

std::string to_yaml(const Scenario& scenario, const NameFile& name_file) {
  std::string text =
      fmt::format("ensonify: 1\nname: {}\nseed: {}\nsequences: {}\n",
                  quoted_if_needed(scenario.name), scenario.seed, scenario.sequences);
  const auto add = [&](std::string_view key, const std::string& written) {
    const Node* drawn = drawn_section(scenario, key);
    text += drawn != nullptr ? section_text(key, *drawn, name_file) : written;
  };
  add("sonar", sonar_text(scenario.sonar, name_file));
  add("water", water_text(scenario.water, name_file));
  add("scattering", scattering_text(scenario.scattering));
  add("materials", materials_text(scenario.materials, name_file));
  add("objects", objects_text(scenario.objects, name_file));
  add("point_targets", point_targets_text(scenario.point_targets));
  add("volumes", volumes_text(scenario.volumes, name_file));
  add("multipath", multipath_text(scenario));
  add("trajectory", trajectory_text(scenario.trajectory, name_file));
  add("motion_within_ping", scenario.motion_within_ping ? "motion_within_ping: true\n" : "");
  add("noise", noise_text(scenario));
  add("synthesis",
      fmt::format("synthesis: {{tolerance: {}}}\n", number(scenario.synthesis_tolerance)));
  add("output", output_text(scenario));
  add("splits",
      fmt::format("splits: {{train: {}, val: {}, test: {}}}\n", number(scenario.splits.train),
                  number(scenario.splits.val), number(scenario.splits.test)));
  return text;
}

}  // namespace ensonify
