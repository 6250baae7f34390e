#include <algorithm>

#include "core/units.h"
#include "scenario/drawn_sections.h"
#include "scenario/scenario.h"

namespace ensonify {

Sonar sonar_of(const Scenario& scenario) {
  const SonarSpec& spec = scenario.sonar;
  Sonar sonar;
  sonar.frequency_hz = spec.frequency_hz;
  sonar.bandwidth_hz = spec.bandwidth_hz;
  sonar.pulse.shape = spec.pulse.shape;
  sonar.pulse.duration_s = spec.pulse.duration_s;
  sonar.pulse.taper = spec.pulse.taper;
  sonar.window = spec.window;
  sonar.shading = spec.shading;
  sonar.transmit_width_rad = radians(spec.transmit_width_deg.value_or(0));
  sonar.adc = spec.adc;
  sonar.source_level_db = spec.source_level_db;
  sonar.range_min_m = spec.range_min_m;
  sonar.range_max_m = spec.range_max_m;
  sonar.beam_count = spec.beam_count;
  sonar.beam_spacing_rad = radians(spec.beam_fov_deg) / spec.beam_count;
  sonar.beam_width_rad = radians(spec.beam_width_deg);
  sonar.elevation_width_rad = radians(spec.elevation_width_deg);
  sonar.elevation_fan_rad = radians(spec.elevation_fan_deg);
  sonar.rays_elevation = spec.rays_elevation;
  sonar.rays_azimuth = spec.rays_azimuth;
  sonar.rays_per_cell = spec.rays_per_cell;
  sonar.normalization = scenario.scattering.normalization;
  return sonar;
}

Material material_of(const MaterialSpec& spec, const ScatteringSpec& scattering) {
  Material material;
  material.reflectivity = spec.reflectivity;
  material.lambert_exponent = scattering.lambert_exponent;
  if (const auto* lambert = std::get_if<LambertSpec>(&spec.law)) {
    if (lambert->exponent) material.lambert_exponent = *lambert->exponent;
  } else if (std::holds_alternative<LommelSeeligerSpec>(spec.law)) {
    material.law = ScatteringLaw::lommel_seeliger;
  } else {
    material.law = ScatteringLaw::table;
  }
  if (const auto* rician = std::get_if<RicianSpec>(&spec.coherent)) {
    material.coherent = CoherentModel::rician;
    material.rician_k = rician->k;
  } else if (const auto* kirchhoff = std::get_if<KirchhoffSpec>(&spec.coherent)) {
    material.coherent = CoherentModel::kirchhoff;
    material.reflection = kirchhoff->reflection;
    material.roughness_rms_m = kirchhoff->roughness_rms_m;
  }
  return material;
}

Pose pose_of(const PoseSpec& spec) {
  Pose pose;
  pose.position_m = {spec.position_m[0], spec.position_m[1], spec.position_m[2]};
  if (const auto* angles = std::get_if<std::array<double, 3>>(&spec.rotation)) {
    pose.rotation =
        from_roll_pitch_yaw(radians((*angles)[0]), radians((*angles)[1]), radians((*angles)[2]));
  } else {
    pose.rotation = normalized(std::get<Quat>(spec.rotation));
  }
  return pose;
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

std::vector<std::filesystem::path> input_files(const Scenario& scenario) {
  std::vector<std::filesystem::path> files;
  const auto add = [&](const std::filesystem::path& file) {
    if (std::find(files.begin(), files.end(), file) == files.end()) files.push_back(file);
  };
  // A section that is drawn names more than this sequence uses.
  const auto add_drawn = [&](std::string_view key) {
    const Node* drawn = drawn_section(scenario, key);
    if (drawn == nullptr) return false;
    for (const std::filesystem::path& file : section_files(*drawn)) add(file);
    return true;
  };
  if (!add_drawn("sonar") && !scenario.sonar.pulse.file.empty()) add(scenario.sonar.pulse.file);
  if (const auto& profile = scenario.water.profile; !add_drawn("water") && profile) {
    if (!profile->file.empty()) add(profile->file);
  }
  if (!add_drawn("materials")) {
    for (const MaterialSpec& material : scenario.materials) {
      if (const auto* table = std::get_if<BackscatterTableSpec>(&material.law)) add(table->file);
    }
  }
  const auto add_path = [&](const TrajectorySpec& trajectory) {
    if (const auto* path = std::get_if<PathFileSpec>(&trajectory.path)) add(path->file);
  };
  if (!add_drawn("objects")) {
    for (const ObjectSpec& object : scenario.objects) {
      if (const auto* mesh = std::get_if<MeshSpec>(&object.shape)) add(mesh->file);
      if (const auto* solid = std::get_if<LevelSetSpec>(&object.shape)) add(solid->file);
      if (const auto* field = std::get_if<HeightfieldSpec>(&object.shape)) {
        if (!field->file.empty()) add(field->file);
        if (!field->reflectivity_map.empty()) add(field->reflectivity_map);
      }
      if (object.trajectory) add_path(*object.trajectory);
    }
  }
  if (!add_drawn("volumes")) {
    for (const VolumeSpec& volume : scenario.volumes) {
      if (const auto* vdb = std::get_if<VdbVolumeSpec>(&volume.kind)) add(vdb->file);
    }
  }
  if (!add_drawn("trajectory")) add_path(scenario.trajectory);
  return files;
}

}  // namespace ensonify
