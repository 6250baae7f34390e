#include <algorithm>

#include "core/units.h"
#include "scenario/scenario.h"

namespace ensonify {

Sonar sonar_of(const Scenario& scenario) {
  const SonarSpec& spec = scenario.sonar;
  Sonar sonar;
  sonar.frequency_hz = spec.frequency_hz;
  sonar.bandwidth_hz = spec.bandwidth_hz;
  sonar.pulse = spec.pulse;
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
  sonar.normalization = scenario.scattering.normalization;
  return sonar;
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

std::vector<std::filesystem::path> input_files(const Scenario& scenario) {
  std::vector<std::filesystem::path> files;
  const auto add = [&](const std::filesystem::path& file) {
    if (std::find(files.begin(), files.end(), file) == files.end()) files.push_back(file);
  };
  for (const ObjectSpec& object : scenario.objects) {
    if (const auto* mesh = std::get_if<MeshSpec>(&object.shape)) add(mesh->file);
  }
  if (const auto* path = std::get_if<PathFileSpec>(&scenario.trajectory.path)) add(path->file);
  return files;
}

}  // namespace ensonify
