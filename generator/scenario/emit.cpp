#include <type_traits>

#include <fmt/format.h>

#include "scenario/scenario.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

using NameFile = std::function<std::string(const std::filesystem::path&)>;

// The shortest digits that read back the same. YAML 1.1 knows no exponent without a point: 1e-05
// would be text to some readers.
std::string number(double value) {
  std::string text = fmt::format("{}", value);
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) {
    text.insert(exponent, ".0");
  }
  return text;
}

template <std::size_t N>
std::string numbers(const std::array<double, N>& values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + number(value);
  return text + "]";
}

// Plain only if no reader could take it for anything else.
std::string quoted_if_needed(const std::string& text) {
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
  constexpr std::string_view kOthers = "0123456789.-/";
  const auto one_of = [](char c, std::string_view set) {
    return set.find(c) != std::string_view::npos;
  };
  bool plain = !text.empty() && one_of(text[0], kLetters);
  for (const char c : text) plain = plain && (one_of(c, kLetters) || one_of(c, kOthers));
  for (const char* word : {"null", "y", "n"}) plain = plain && !equals_ignoring_case(text, word);
  if (plain && classify_plain(text) == PlainKind::text) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string rotation(const RotationSpec& spec) {
  if (const auto* angles = std::get_if<std::array<double, 3>>(&spec)) {
    return "rotation_deg: " + numbers(*angles);
  }
  const Quat& q = std::get<Quat>(spec);
  return "quaternion_wxyz: " + numbers(std::array<double, 4>{q.w, q.x, q.y, q.z});
}

std::string pose_keys(const PoseSpec& pose) {
  return fmt::format("position_m: {}, {}", numbers(pose.position_m), rotation(pose.rotation));
}

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
  line("rays",
       fmt::format("{{elevation: {}, azimuth: {}}}", sonar.rays_elevation, sonar.rays_azimuth));
  if (sonar.adc) {
    line("receiver", fmt::format("{{adc: {{bits: {}, full_scale_db: {}}}}}", sonar.adc->bits,
                                 number(sonar.adc->full_scale_db)));
  }
  line("mount", fmt::format("{{{}}}", pose_keys(sonar.mount)));
  return text;
}

std::string water_text(const WaterSpec& water) {
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
  return fmt::format("water:\n  sound_speed_m_s: {}\n  absorption: {{{}}}\n", speed, absorption);
}

std::string scattering_text(const ScatteringSpec& scattering) {
  return fmt::format(
      "scattering: {{lambert_exponent: {}, normalization: {}, speckle: {}}}\n",
      number(scattering.lambert_exponent),
      scattering.normalization == Normalization::calibrated ? "calibrated" : "mean_square",
      scattering.speckle == SpeckleMode::per_ping ? "per_ping" : "per_ray");
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

std::string shape_text(const ShapeSpec& shape, const NameFile& name_file) {
  return std::visit(
      [&](const auto& s) -> std::string {
        using S = std::decay_t<decltype(s)>;
        if constexpr (std::is_same_v<S, BoxSpec>) {
          return fmt::format("box: {{size_m: {}, inside: {}}}", numbers(s.size_m), s.inside);
        } else if constexpr (std::is_same_v<S, SphereSpec>) {
          return fmt::format("sphere: {{radius_m: {}, inside: {}}}", number(s.radius_m), s.inside);
        } else if constexpr (std::is_same_v<S, CylinderSpec>) {
          return fmt::format("cylinder: {{radius_m: {}, height_m: {}}}", number(s.radius_m),
                             number(s.height_m));
        } else if constexpr (std::is_same_v<S, PlaneSpec>) {
          return "plane: {}";
        } else {
          return fmt::format("mesh: {{file: {}, scale: {}, normals: {}, reflectivity: {}}}",
                             quoted_if_needed(name_file(s.file)), number(s.scale),
                             s.smooth_normals ? "smooth" : "face",
                             s.vertex_reflectivity ? "vertex_color" : "material");
        }
      },
      shape);
}

std::string objects_text(const std::vector<ObjectSpec>& objects, const NameFile& name_file) {
  if (objects.empty()) return "objects: []\n";
  std::string text = "objects:\n";
  for (const ObjectSpec& object : objects) {
    text += fmt::format("  - {{name: {}, class: {}, material: {}, shape: {{{}}}, pose: {{{}}}}}\n",
                        quoted_if_needed(object.name), quoted_if_needed(object.class_name),
                        quoted_if_needed(object.material), shape_text(object.shape, name_file),
                        pose_keys(object.pose));
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

std::string volumes_text(const std::vector<VolumeSpec>& volumes) {
  if (volumes.empty()) return "volumes: []\n";
  std::string text = "volumes:\n";
  for (const VolumeSpec& volume : volumes) {
    text += fmt::format("  - {{name: {}, class: {}, uniform: {{strength_db: {}}}}}\n",
                        quoted_if_needed(volume.name), quoted_if_needed(volume.class_name),
                        number(volume.strength_db));
  }
  return text;
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

std::string trajectory_text(const TrajectorySpec& trajectory, const NameFile& name_file) {
  std::string text = "trajectory:\n";
  if (const auto* path = std::get_if<PathFileSpec>(&trajectory.path)) {
    text += fmt::format("  file: {}\n", quoted_if_needed(name_file(path->file)));
  } else {
    text += "  poses:\n";
    for (const TimedPoseSpec& pose : std::get<std::vector<TimedPoseSpec>>(trajectory.path)) {
      text += fmt::format("    - {{time_s: {}, {}}}\n", number(pose.time_s), pose_keys(pose.pose));
    }
  }
  text += fmt::format("  ping_rate_hz: {}\n", number(trajectory.ping_rate_hz));
  if (trajectory.pings) text += fmt::format("  pings: {}\n", *trajectory.pings);
  return text;
}

std::string output_text(const OutputSpec& output) {
  std::string cartesian = "false";
  if (output.selection.cartesian) {
    cartesian = fmt::format("{{height_px: {}}}", output.cartesian_height_px);
  }
  std::string png = output.selection.png ? "true" : "false";
  if (output.selection.png && output.png_db) {
    png = fmt::format("{{db: {}}}", numbers(*output.png_db));
  }
  return fmt::format(
      "output: {{timeseries: {}, polar: {}, cartesian: {}, png: {}, scatterers: {}}}\n",
      output.selection.timeseries ? "npy" : "none", output.selection.polar, cartesian, png,
      output.selection.scatterers);
}

}  // namespace

std::string to_yaml(const Scenario& scenario, const NameFile& name_file) {
  std::string text =
      fmt::format("ensonify: 1\nname: {}\nseed: {}\nsequences: {}\n",
                  quoted_if_needed(scenario.name), scenario.seed, scenario.sequences);
  text += sonar_text(scenario.sonar, name_file);
  text += water_text(scenario.water);
  text += scattering_text(scenario.scattering);
  text += materials_text(scenario.materials, name_file);
  text += objects_text(scenario.objects, name_file);
  text += point_targets_text(scenario.point_targets);
  text += volumes_text(scenario.volumes);
  text += trajectory_text(scenario.trajectory, name_file);
  text += noise_text(scenario);
  text += fmt::format("synthesis: {{tolerance: {}}}\n", number(scenario.synthesis_tolerance));
  text += output_text(scenario.output);
  text += fmt::format("splits: {{train: {}, val: {}, test: {}}}\n", number(scenario.splits.train),
                      number(scenario.splits.val), number(scenario.splits.test));
  return text;
}

}  // namespace ensonify
